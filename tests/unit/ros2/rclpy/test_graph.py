"""Joining, leaving and refused requests."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator

import msgspec.structs
import pytest
import pytest_asyncio

from contract.graphs import BOOL, STRING, Inbox, string
from ros2_domains import own_domain
from rostether.errors import GraphError, InvalidNameError, TypeMismatchError
from rostether.msgdef.interface import ANY_MESSAGE, MessageType
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.rclpy.context import RclpyContext
from rostether.ros2.types.type_support import MessageSupport, Ros2Types
from waiting import until

pytestmark = pytest.mark.rclpy


class OddTypes(Ros2Types):
    """Has a definition of String that differs from the installed one."""

    def message(self, message_type: MessageType) -> MessageSupport:
        support = super().message(message_type)
        if message_type is STRING:
            return msgspec.structs.replace(support, type_hash="RIHS01_" + "0" * 64)
        return support


async def open_context(types: type[Ros2Types] = Ros2Types) -> RclpyContext:
    return await RclpyContext.open(types(Registry(), Ros2Definitions()), domain_id=own_domain())


@pytest_asyncio.fixture
async def context() -> AsyncIterator[RclpyContext]:
    context = await open_context()
    yield context
    await context.close()


@pytest.mark.parametrize("name", ["/a/b__c/4", "/9lives"])
async def test_an_invalid_name_is_refused(context: RclpyContext, name: str) -> None:
    with pytest.raises(InvalidNameError) as caught:
        await context.join(name)
    assert "\n" not in str(caught.value)
    assert await context.join("/good")


async def test_closing_leaves_with_all_nodes() -> None:
    context = await open_context()
    first, second = await context.join("/first"), await context.join("/second")
    await first.close()
    await context.close()
    await context.close()
    assert await second.wait_closed() == "closed"
    with pytest.raises(GraphError, match="open it again"):
        await context.join("/third")


async def test_two_nodes_may_have_the_same_name(context: RclpyContext) -> None:
    one, other, inbox = await context.join("/node"), await context.join("/node"), Inbox()
    await other.subscribe("/chat", STRING, inbox.store)
    publisher = await one.advertise("/chat", STRING)
    await until(lambda: publisher.subscriber_count == 1)
    await one.close()
    assert (await other.snapshot()).nodes == ("/node",)


async def test_a_topic_has_one_type_in_a_process(context: RclpyContext) -> None:
    one, other = await context.join("/one"), await context.join("/other")
    await one.advertise("/chat", STRING)
    with pytest.raises(TypeMismatchError, match="this process already uses it as std_msgs/msg/String"):
        await other.subscribe("/chat", BOOL, Inbox().store)


async def test_a_definition_that_differs_from_the_installed_one_is_refused() -> None:
    context = await open_context(OddTypes)
    node = await context.join("/node")
    for attempt in (node.advertise("/chat", STRING), node.subscribe("/chat", STRING, Inbox().store)):
        with pytest.raises(TypeMismatchError, match="installed for rclpy differs from the known one"):
            await attempt
    assert "/chat" not in (await node.snapshot()).topics
    await node.advertise("/flag", BOOL)
    await context.close()


async def test_a_payload_that_is_malformed_is_skipped(
    context: RclpyContext, caplog: pytest.LogCaptureFixture
) -> None:
    node, inbox = await context.join("/node"), Inbox()
    await node.subscribe("/chat", STRING, inbox.store)
    publisher = await node.advertise("/chat", STRING)
    await until(lambda: publisher.subscriber_count == 1)
    with caplog.at_level(logging.WARNING, logger="rostether.ros2"):
        for _ in range(2):
            publisher.publish_raw([string("before"), b"\xff\xff\xff\xffx", string("after")])
    await until(lambda: len(inbox.payloads) == 4)
    assert inbox.payloads == [string("before"), string("after")] * 2
    assert caplog.text.count("a message for /chat:") == 1


@pytest.mark.parametrize("message_type", [STRING, ANY_MESSAGE])
async def test_a_nodes_own_messages_can_be_omitted(context: RclpyContext, message_type: MessageType) -> None:
    node, other, inbox = await context.join("/node"), await context.join("/other"), Inbox()
    own, theirs = await node.advertise("/chat", STRING), await other.advertise("/chat", STRING)
    await node.subscribe("/chat", message_type, inbox.store, skip_own=True)
    await until(lambda: own.subscriber_count == theirs.subscriber_count == 1)
    for number in range(3):
        own.publish_raw([string("own")])
        theirs.publish_raw([string(f"theirs {number}")])
    await until(lambda: len(inbox.payloads) == 3)
    assert inbox.payloads == [string(f"theirs {number}") for number in range(3)]
