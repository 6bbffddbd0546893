"""Publishing and subscribing."""

from __future__ import annotations

import pytest

from contract.capabilities import Capabilities
from contract.graphs import BOOL, STRING, TRUE, Inbox, string, wait_for_nodes, wait_for_snapshot
from rostether.errors import GraphError, TypeMismatchError
from rostether.graph.ports import JoinGraph
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.msgdef.registry import Registry
from waiting import until


async def test_batches_arrive_completely_and_in_order(join: JoinGraph) -> None:
    talker, listener = await join("/talker"), await join("/listener")
    inbox = Inbox()
    publisher = await talker.advertise("/chat", STRING)
    subscriber = await listener.subscribe("/chat", STRING, inbox.store)
    await until(lambda: publisher.subscriber_count == 1 and subscriber.publisher_count == 1)
    sent = [string(f"message {number}") for number in range(1000)]
    assert publisher.publish_raw(sent[:3])
    assert publisher.publish_raw(sent[3:4])
    assert publisher.publish_raw([])
    assert publisher.publish_raw(sent[4:])
    await until(lambda: len(inbox.payloads) == 1000)
    assert inbox.payloads == sent
    assert publisher.topic == subscriber.topic == "/chat"
    assert publisher.type == STRING


async def test_empty_and_large_payloads_arrive(join: JoinGraph) -> None:
    node, inbox = await join("/node"), Inbox()
    publisher = await node.advertise("/big", STRING)
    await node.subscribe("/big", STRING, inbox.store)
    await until(lambda: publisher.subscriber_count == 1)
    sent = [string(""), string("x" * (3 << 20)), string(""), string("end")]
    publisher.publish_raw(sent)
    await until(lambda: len(inbox.payloads) == 4)
    assert inbox.payloads == sent


async def test_every_subscriber_gets_every_message(join: JoinGraph) -> None:
    talker, other, listener = await join("/talker"), await join("/other"), await join("/listener")
    inboxes = [Inbox(), Inbox(), Inbox()]
    publishers = [await talker.advertise("/chat", STRING), await other.advertise("/chat", STRING)]
    subscribers = [
        await listener.subscribe("/chat", STRING, inboxes[0].store),
        # A second handle in the same node, and one in a node that publishes the topic itself.
        await listener.subscribe("/chat", STRING, inboxes[1].store),
        await other.subscribe("/chat", ANY_MESSAGE, inboxes[2].store),
    ]
    await until(lambda: all(each.subscriber_count == 3 for each in publishers))
    await until(lambda: all(each.publisher_count == 2 for each in subscribers))
    for publisher in publishers:
        publisher.publish_raw([string("hello")])
    await until(lambda: all(len(inbox.payloads) == 2 for inbox in inboxes))


async def test_the_order_of_joining_does_not_matter(join: JoinGraph) -> None:
    listener, inbox = await join("/listener"), Inbox()
    await listener.subscribe("/chat", STRING, inbox.store)
    talker = await join("/talker")
    publisher = await talker.advertise("/chat", STRING)
    await until(lambda: publisher.subscriber_count == 1)
    publisher.publish_raw([string("hello")])
    await until(lambda: inbox.payloads)


async def test_a_late_subscriber_gets_the_last_message_of_a_latched_topic(join: JoinGraph) -> None:
    talker, listener = await join("/talker"), await join("/listener")
    observer, observed = await join("/observer"), Inbox()
    publisher = await talker.advertise("/map", STRING, latch=True)
    await observer.subscribe("/map", STRING, observed.store)
    publisher.publish_raw([string("old"), string("new")])
    # Some graphs send in another thread.
    await until(lambda: string("new") in observed.payloads)
    for _ in range(2):
        inbox = Inbox()
        await listener.subscribe("/map", STRING, inbox.store, on_connection=inbox.store_header)
        await until(lambda: inbox.payloads)  # noqa: B023 - awaited at once
        assert inbox.payloads == [string("new")]
        assert inbox.headers[0]["latching"] == "1"


async def test_a_late_subscriber_gets_no_earlier_message_of_another_topic(join: JoinGraph) -> None:
    talker, listener, inbox = await join("/talker"), await join("/listener"), Inbox()
    publisher = await talker.advertise("/chat", STRING)
    publisher.publish_raw([string("before")])
    await listener.subscribe("/chat", STRING, inbox.store, on_connection=inbox.store_header)
    await until(lambda: publisher.subscriber_count == 1)
    publisher.publish_raw([string("after")])
    await until(lambda: inbox.payloads)
    assert inbox.payloads == [string("after")]
    assert inbox.headers[0]["latching"] == "0"


async def test_a_connection_has_the_publisher_and_its_type(
    join: JoinGraph, capabilities: Capabilities
) -> None:
    talker, listener, inbox = await join("/talker"), await join("/listener"), Inbox()
    await talker.advertise("/chat", STRING)
    await listener.subscribe("/chat", ANY_MESSAGE, inbox.store, on_connection=inbox.store_header)
    await until(lambda: inbox.headers)
    (header,) = inbox.headers
    assert header["callerid"] == "/talker"
    assert (header["type"], header["md5sum"]) == (STRING.name, STRING.md5sum)
    if capabilities.sends_definitions:
        assert header["message_definition"] == STRING.definition
    registry = Registry(bundled=False)
    registry.add_full_text(STRING.name, header["message_definition"])
    assert registry.message_type(STRING.name).md5sum == STRING.md5sum


async def test_a_subscriber_of_another_type_receives_nothing(
    join: JoinGraph, capabilities: Capabilities
) -> None:
    talker, listener = await join("/talker"), await join("/listener")
    wrong, right = Inbox(), Inbox()
    publisher = await talker.advertise("/chat", STRING)
    try:
        await listener.subscribe("/chat", BOOL, wrong.store)
    except TypeMismatchError as error:
        assert not capabilities.allows_different_types
        assert "String" in str(error)
    await listener.subscribe("/chat", STRING, right.store)
    await until(lambda: publisher.subscriber_count == 1)
    publisher.publish_raw([string("hello")])
    await until(lambda: right.payloads)
    assert wrong.payloads == []


async def test_a_subscriber_of_one_type_follows_the_publishers(
    join: JoinGraph, capabilities: Capabilities
) -> None:
    capabilities.require("allows_different_types")
    talker, other, listener = await join("/talker"), await join("/other"), await join("/listener")
    inbox = Inbox()
    publisher = await talker.advertise("/chat", STRING)
    subscriber = await listener.subscribe(
        "/chat", ANY_MESSAGE, inbox.store, on_connection=inbox.store_header, one_type=True
    )
    await until(lambda: publisher.subscriber_count == 1)
    wrong = await other.advertise("/chat", BOOL)
    await wait_for_snapshot(listener, lambda snapshot: len(snapshot.topics["/chat"].publishers) == 2)
    wrong.publish_raw([TRUE])
    await wrong.close()
    publisher.publish_raw([string("hello")])
    await until(lambda: inbox.payloads)
    await publisher.close()
    await until(lambda: subscriber.publisher_count == 0)
    publisher = await other.advertise("/chat", BOOL)
    await until(lambda: len(inbox.headers) == 2 and publisher.subscriber_count == 1)
    publisher.publish_raw([TRUE])
    await until(lambda: len(inbox.payloads) == 2)
    assert inbox.payloads == [string("hello"), TRUE]
    assert [header["type"] for header in inbox.headers] == [STRING.name, BOOL.name]


async def test_a_paused_subscriber_loses_nothing(join: JoinGraph) -> None:
    talker, listener = await join("/talker"), await join("/listener")
    inbox, other_inbox = Inbox(), Inbox()
    publisher = await talker.advertise("/chat", STRING)
    subscriber = await listener.subscribe("/chat", STRING, inbox.store)
    await listener.subscribe("/chat", STRING, other_inbox.store)
    await until(lambda: publisher.subscriber_count == 2 and subscriber.publisher_count == 1)
    subscriber.pause()
    subscriber.pause()
    sent = [string(f"message {number}") for number in range(100)]
    publisher.publish_raw(sent)
    await until(lambda: len(other_inbox.payloads) == 100)
    assert inbox.payloads == []
    subscriber.resume()
    subscriber.resume()
    await until(lambda: len(inbox.payloads) == 100)
    assert inbox.payloads == sent


async def test_a_subscriber_may_skip_messages_of_its_own_node(join: JoinGraph) -> None:
    node, other = await join("/node"), await join("/other")
    inbox, other_inbox = Inbox(), Inbox()
    own, others = await node.advertise("/chat", STRING), await other.advertise("/chat", STRING)
    subscriber = await node.subscribe("/chat", STRING, inbox.store, skip_own=True)
    await other.subscribe("/chat", STRING, other_inbox.store)
    await until(lambda: own.subscriber_count >= 1 and others.subscriber_count == 2)
    await until(lambda: subscriber.publisher_count >= 1)
    await wait_for_snapshot(node, lambda snapshot: "/other" in snapshot.topics["/chat"].subscribers)
    for number in range(3):
        own.publish_raw([string(f"own {number}")])
        others.publish_raw([string(f"other {number}")])
    await until(lambda: len(other_inbox.payloads) == 6 and len(inbox.payloads) >= 3)
    assert inbox.payloads == [string(f"other {number}") for number in range(3)]


async def test_a_subscriber_may_skip_nodes(join: JoinGraph) -> None:
    node, other, other_inbox = await join("/node"), await join("/other"), Inbox()
    names: set[str] = set()
    inbox = Inbox()
    await node.subscribe("/chat", STRING, inbox.store, skip_nodes=names)
    await node.subscribe("/chat", STRING, other_inbox.store)
    names.add("/skipped")
    skipped = await join("/skipped")
    publishers = [await graph.advertise("/chat", STRING) for graph in (node, other, skipped)]
    await wait_for_nodes(node, other, skipped)
    await until(lambda: all(publisher.subscriber_count >= 1 for publisher in publishers))
    await wait_for_snapshot(node, lambda snapshot: len(snapshot.topics["/chat"].publishers) == 3)

    def publish_from_all() -> bool:
        for number, publisher in enumerate(publishers):
            publisher.publish_raw([string(f"from {number}")])
        return all(string(f"from {number}") in other_inbox.payloads for number in range(3))

    await until(publish_from_all)
    await until(lambda: {string("from 0"), string("from 1")} <= set(inbox.payloads))
    assert string("from 2") not in inbox.payloads
    # The names may change at any time, even while a publisher is connected.
    names.clear()
    names.add("/other")

    def receives_from_the_third() -> bool:
        publish_from_all()
        return string("from 2") in inbox.payloads

    await until(receives_from_the_third)
    count = inbox.payloads.count(string("from 1"))
    received = other_inbox.payloads.count(string("from 1"))
    publishers[1].publish_raw([string("from 1")])
    await until(lambda: other_inbox.payloads.count(string("from 1")) > received)
    assert inbox.payloads.count(string("from 1")) == count


async def test_a_subscription_works_after_an_error_of_its_callback(
    join: JoinGraph, caplog: pytest.LogCaptureFixture
) -> None:
    node, inbox = await join("/node"), Inbox()

    def fail(_: object) -> None:
        raise ZeroDivisionError("a user's mistake")

    publisher = await node.advertise("/chat", STRING)
    broken = await node.subscribe("/chat", STRING, fail, on_connection=fail)
    await node.subscribe("/chat", STRING, inbox.store)
    await until(lambda: publisher.subscriber_count == 2)
    for count in (1, 2):
        publisher.publish_raw([string("hello")])
        await until(lambda: len(inbox.payloads) == count)  # noqa: B023 - awaited at once
    await until(
        lambda: caplog.text.count("on_messages of /chat failed: ZeroDivisionError: a user's mistake") == 2
    )
    assert "on_connection of /chat failed" in caplog.text
    assert broken.publisher_count == 1


async def test_closing_a_publisher_disconnects_its_subscribers(join: JoinGraph) -> None:
    talker, listener, inbox = await join("/talker"), await join("/listener"), Inbox()
    publisher = await talker.advertise("/chat", STRING)
    subscriber = await listener.subscribe("/chat", STRING, inbox.store)
    await until(lambda: publisher.subscriber_count == 1 and subscriber.publisher_count == 1)
    publisher.publish_raw([string("last words")])
    await publisher.close()
    await publisher.close()
    assert publisher.publish_raw([string("from beyond")])
    await until(lambda: subscriber.publisher_count == 0 and inbox.payloads)
    assert inbox.payloads == [string("last words")]
    assert publisher.subscriber_count == 0
    again = await talker.advertise("/chat", STRING)
    await until(lambda: again.subscriber_count == 1)


async def test_a_publisher_of_a_closed_node_has_no_subscribers_and_drops_messages(join: JoinGraph) -> None:
    talker, listener = await join("/talker"), await join("/listener")
    publisher = await talker.advertise("/chat", STRING)
    await listener.subscribe("/chat", STRING, Inbox().store)
    await until(lambda: publisher.subscriber_count)
    await talker.close()
    assert publisher.publish_raw([string("late")])
    assert publisher.subscriber_count == 0


async def test_no_callback_runs_after_a_subscriber_is_closed(join: JoinGraph) -> None:
    talker, listener = await join("/talker"), await join("/listener")
    closed, other_inbox = Inbox(), Inbox()
    publisher = await talker.advertise("/chat", STRING)
    subscriber = await listener.subscribe("/chat", STRING, closed.store)
    await listener.subscribe("/chat", STRING, other_inbox.store)
    await until(lambda: publisher.subscriber_count == 2)
    publisher.publish_raw([string("too late")] * 100)
    await subscriber.close()
    count = len(closed.payloads)
    await subscriber.close()
    publisher.publish_raw([string("too late")])
    await until(lambda: len(other_inbox.payloads) == 101)
    assert len(closed.payloads) == count
    await until(lambda: publisher.subscriber_count == 1)
    assert subscriber.publisher_count == 0


async def test_two_handles_on_one_topic_share_its_subscribers(join: JoinGraph) -> None:
    talker, listener, inbox = await join("/talker"), await join("/listener"), Inbox()
    first = await talker.advertise("/chat", STRING)
    second = await talker.advertise("/chat", STRING)
    await listener.subscribe("/chat", STRING, inbox.store)
    await until(lambda: first.subscriber_count == second.subscriber_count == 1)
    await first.close()
    assert second.publish_raw([string("still here")])
    await until(lambda: inbox.payloads)
    with pytest.raises(TypeMismatchError, match="std_msgs/Bool"):
        await talker.advertise("/chat", BOOL)


async def test_names_are_resolved_and_remapped(join: JoinGraph) -> None:
    robot = await join("board", namespace="/robot", remappings={"chat": "/talk"})
    other, inbox = await join("/other"), Inbox()
    assert robot.node_name == "/robot/board"
    assert robot.resolve("~state") == "/robot/board/state"
    assert robot.resolve("odom") == "/robot/odom"
    publisher = await robot.advertise("chat", STRING)
    assert publisher.topic == "/talk"
    await other.subscribe("talk", STRING, inbox.store)
    await until(lambda: publisher.subscriber_count == 1)
    publisher.publish_raw([string("hello")])
    await until(lambda: inbox.payloads)


async def test_a_node_that_has_left_accepts_no_requests(join: JoinGraph) -> None:
    node = await join("/node")
    await node.close()
    with pytest.raises(GraphError, match="has left the graph"):
        await node.advertise("/chat", STRING)
    with pytest.raises(GraphError, match="has left the graph"):
        await node.subscribe("/chat", STRING, Inbox().store)
