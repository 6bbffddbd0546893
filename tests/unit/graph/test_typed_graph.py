from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import aclosing
from pathlib import Path
from typing import TYPE_CHECKING, Any, assert_type

import pytest
import pytest_asyncio

from loop_watch import LoopWatch
from rostether.errors import (
    GraphError,
    InvalidNameError,
    SerializationError,
    ServiceCallError,
    TypeMismatchError,
    UnknownTypeError,
)
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.message_stream import LearnedTypes
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from rostether.srv.std_srvs import SetBool, SetBoolRequest, SetBoolResponse, TriggerRequest

LOCAL_TEXT = "float32 temperature\nstring[] tags\n"


@pytest.fixture
def network() -> MemoryNetwork:
    return MemoryNetwork()


async def enter(network: MemoryNetwork, name: str) -> TypedGraph:
    return TypedGraph(await network.join(name), TypeStore(Registry()))


@pytest_asyncio.fixture
async def talker(network: MemoryNetwork) -> AsyncIterator[TypedGraph]:
    graph = await enter(network, "/talker")
    yield graph
    await graph.close()


@pytest_asyncio.fixture
async def listener(network: MemoryNetwork) -> AsyncIterator[TypedGraph]:
    graph = await enter(network, "/listener")
    yield graph
    await graph.close()


async def take(graph: TypedGraph, topic: str, count: int) -> list[Message]:
    found: list[Message] = []
    async with aclosing(aiter(graph.messages(topic))) as messages:
        async for message in messages:
            found.append(message)
            if len(found) == count:
                break
    return found


async def test_messages_learn_the_type_from_the_publisher(talker: TypedGraph, listener: TypedGraph) -> None:
    publisher = await talker.publisher("/chatter", "std_msgs/String")
    receiving = asyncio.create_task(take(listener, "/chatter", 2))
    assert await publisher.wait_for_subscriber(5.0)
    publisher.publish({"data": "one"})
    publisher.publish(data="two")
    assert [message.data for message in await receiving] == ["one", "two"]


async def test_messages_of_an_unknown_type(network: MemoryNetwork, listener: TypedGraph) -> None:
    registry = Registry(bundled=False)
    registry.add_full_text("my_robot/Probe", LOCAL_TEXT)
    talker = TypedGraph(await network.join("/talker"), TypeStore(registry))
    publisher = await talker.publisher("/probe", "my_robot/Probe", latch=True)
    publisher.publish(temperature=21.5, tags=["a", "b"])
    message = await listener.wait_for_message("/probe", timeout_s=60)
    assert (message.temperature, message.tags) == (21.5, ["a", "b"])


async def test_a_type_with_another_definition_is_decoded_with_its_publishers(
    network: MemoryNetwork, listener: TypedGraph
) -> None:
    registry = Registry(bundled=False)
    registry.add_full_text("std_msgs/String", "int32 not_data\n")
    talker = TypedGraph(await network.join("/talker"), TypeStore(registry))
    publisher = await talker.publisher("/chatter", "std_msgs/String", latch=True)
    publisher.publish(not_data=7)
    assert (await listener.wait_for_message("/chatter", timeout_s=60)).not_data == 7
    # in this graph, the name still has its earlier definition
    assert listener.store.codec("std_msgs/String").message_class(data="x").data == "x"


async def test_an_unknown_type_without_a_definition_has_a_hint(
    talker: TypedGraph, listener: TypedGraph
) -> None:
    await talker.raw.advertise("/secret", MessageType("my_robot/Secret", "0" * 32))
    with pytest.raises(UnknownTypeError, match="--msg-path"):
        await listener.wait_for_message("/secret", timeout_s=60)


def test_another_md5sum_without_a_definition_is_a_mismatch() -> None:
    types = LearnedTypes(TypeStore(Registry()))
    with pytest.raises(TypeMismatchError, match="sends no definition"):
        types.codec({"type": "std_msgs/String", "md5sum": "0" * 32})


async def test_a_busy_loop_loses_the_oldest_messages_and_counts_them(
    talker: TypedGraph, listener: TypedGraph
) -> None:
    publisher = await talker.publisher("/count", "std_msgs/UInt32")
    stream = listener.messages("/count", queue_size=2)
    async with aclosing(aiter(stream)) as messages:
        first = asyncio.ensure_future(anext(messages))
        assert await publisher.wait_for_subscriber(5.0)
        publisher.publish(data=0)
        assert (await first).data == 0
        for number in range(1, 6):
            publisher.publish(data=number)
        assert (await anext(messages)).data == 4
        assert (await anext(messages)).data == 5
    assert stream.dropped_count == 3
    assert publisher.subscriber_count == 0


async def test_messages_without_their_types_layout_are_skipped_and_counted(
    talker: TypedGraph, listener: TypedGraph
) -> None:
    publisher = await talker.publisher("/chatter", "std_msgs/String")
    stream = listener.messages("/chatter")
    async with aclosing(aiter(stream)) as messages:
        first = asyncio.ensure_future(anext(messages))
        assert await publisher.wait_for_subscriber(5.0)
        publisher.raw.publish_raw([b"\xff\xff\xff\xff", b"\x02\x00\x00\x00ok"])
        assert (await first).data == "ok"
    assert stream.misfit_count == 1


async def test_a_loop_ends_when_its_node_leaves(talker: TypedGraph, listener: TypedGraph) -> None:
    publisher = await talker.publisher("/chatter", "std_msgs/String")
    receiving = asyncio.create_task(take(listener, "/chatter", 1))
    assert await publisher.wait_for_subscriber(5.0)
    await listener.close()
    assert await asyncio.wait_for(receiving, 60) == []
    with pytest.raises(GraphError, match="has left the graph"):
        await listener.wait_for_message("/chatter", timeout_s=60)


async def test_no_subscriber(talker: TypedGraph) -> None:
    publisher = await talker.publisher("/chatter", "std_msgs/String")
    assert not await publisher.wait_for_subscriber(0.02)


@pytest.mark.parametrize("closes_node", [False, True])
async def test_no_wait_for_subscribers_of_a_closed_publisher(talker: TypedGraph, closes_node: bool) -> None:
    publisher = await talker.publisher("/chatter", "std_msgs/String")
    waiting = asyncio.create_task(publisher.wait_for_subscriber())
    await asyncio.sleep(0)
    await (talker.close() if closes_node else publisher.close())
    for wait in (waiting, publisher.wait_for_subscriber()):
        with pytest.raises(GraphError, match="the publisher of /chatter was closed"):
            await asyncio.wait_for(wait, 60)


async def test_what_cannot_be_called_is_refused_at_once(talker: TypedGraph) -> None:
    nothing: Any = None
    with pytest.raises(TypeError, match=r"the callback must be a function, not None; write .* without \(\)"):
        await talker.subscriber("/chatter", None, nothing)
    with pytest.raises(TypeError, match="the handler must be a function"):
        await talker.service_server("/switch", "std_srvs/SetBool", nothing)
    with pytest.raises(TypeError, match="the callback must be a function"):
        await talker.watch_param("/rate", nothing)

    async def receive(_: object) -> None: ...

    with pytest.raises(TypeError, match="the callback is async; write a plain function"):
        await talker.watch_param("/rate", receive)  # type: ignore[arg-type]


async def test_logs_format_values_as_rospy(talker: TypedGraph, listener: TypedGraph) -> None:
    seen: list[str] = []
    await listener.subscriber("/rosout", "rosgraph_msgs/Log", lambda log: seen.append(log.msg))
    await asyncio.sleep(0)
    talker.loginfo("%s is %.1f m away", "it", 1.25)
    talker.logwarn(1.5)
    talker.logerror("100 %")
    async with asyncio.timeout(60):
        while len(seen) < 3:
            await asyncio.sleep(0.01)
    assert seen == ["it is 1.2 m away", "1.5", "100 %"]


async def test_a_wrong_field_is_named_to_the_caller(talker: TypedGraph) -> None:
    publisher = await talker.publisher("/chatter", "std_msgs/String")
    with pytest.raises(SerializationError, match="has no field 'dta'"):
        publisher.publish(dta="x")


@pytest.mark.parametrize("is_async", [False, True])
async def test_service_both_ways(talker: TypedGraph, listener: TypedGraph, is_async: bool) -> None:
    def answer(request: Message) -> dict[str, object]:
        return {"success": request.data, "message": "done"}

    async def answer_later(request: Message) -> dict[str, object]:
        return answer(request)

    server = await talker.service_server("/enable", "std_srvs/SetBool", answer_later if is_async else answer)
    response = await listener.call("/enable", "std_srvs/SetBool", {"data": True}, timeout_s=60)
    assert (response.success, response.message) == (True, "done")
    await server.close()


async def test_services_as_classes(talker: TypedGraph, listener: TypedGraph) -> None:
    async def answer(request: SetBoolRequest) -> SetBoolResponse:
        return SetBoolResponse(success=request.data)

    await talker.service_server("/enable", SetBool, answer)
    client = await listener.service_client("/enable", SetBool)
    response = await client.call(data=True, timeout_s=60)
    assert_type(response, SetBoolResponse)
    assert isinstance(response, SetBoolResponse)
    assert response.success
    assert not (await listener.call("/enable", SetBool, SetBoolRequest(data=False), timeout_s=60)).success
    if TYPE_CHECKING:
        await listener.call("/enable", SetBool, TriggerRequest())  # type: ignore[misc]
        SetBoolResponse(sucess=True)  # type: ignore[call-arg]


async def test_a_failing_handler_is_reported_to_the_caller(talker: TypedGraph, listener: TypedGraph) -> None:
    def answer(request: Message) -> dict[str, object]:
        raise RuntimeError("out of paint")

    await talker.service_server("/paint", "std_srvs/Trigger", answer)
    with pytest.raises(ServiceCallError, match="out of paint"):
        await listener.call("/paint", "std_srvs/Trigger", timeout_s=60)


async def test_parameters(talker: TypedGraph, listener: TypedGraph) -> None:
    await talker.set_param("/rate", 5)
    assert await listener.get_param("/rate") == 5
    assert await listener.get_param("/none", 7) == 7
    assert await listener.has_param("/rate")
    assert "/rate" in await listener.list_params()
    assert await listener.search_param("rate") == "/rate"
    await listener.delete_param("/rate")
    assert not await talker.has_param("/rate")


@pytest.fixture
def nearby(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a package of a message and a service."""
    for kind, name, definition in (("msg", "Level", "uint8 value\n"), ("srv", "Fill", "uint8 value\n---\n")):
        (tmp_path / "tank" / kind).mkdir(parents=True)
        (tmp_path / "tank" / kind / f"{name}.{kind}").write_text(definition)
    (tmp_path / "tank" / "package.xml").write_text("<package><name>tank</name></package>")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("what", ["publisher", "messages", "serve", "call"])
async def test_types_are_searched_while_the_loop_continues(
    network: MemoryNetwork, nearby: Path, what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = LoopWatch(monkeypatch)
    graph = TypedGraph(await network.join("/a"), TypeStore(Registry.from_environment(environ={})))
    if what == "publisher":
        await graph.publisher("/level", "tank/Level")
    elif what == "messages":
        with pytest.raises(TimeoutError):
            await graph.wait_for_message("/level", "tank/Level", timeout_s=3.0)
    elif what == "serve":
        await graph.service_server("/fill", "tank/Fill", lambda _: {})
    else:
        with pytest.raises(GraphError):
            await graph.call("/fill", "tank/Fill", timeout_s=60)
    assert graph.store.registry.message_type("tank/Level")
    assert watch.folders
    assert watch.held == 0


async def test_a_publishers_own_definition_needs_no_search(
    network: MemoryNetwork, nearby: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = LoopWatch(monkeypatch)
    types = LearnedTypes(TypeStore(Registry.from_environment(environ={})))
    header = {"type": "tank/Level", "md5sum": "*", "message_definition": "uint8 value\n"}
    assert types.codec(header).decode(b"\x07").value == 7
    assert (watch.folders, watch.held) == (0, 0)


async def test_a_message_of_one_field_is_published_by_its_value(
    talker: TypedGraph, listener: TypedGraph
) -> None:
    publisher = await talker.publisher("/chatter", "std_msgs/String", latch=True)
    publisher.publish("hello")
    message = await listener.wait_for_message("/chatter", timeout_s=60)
    assert message.data == "hello"
    assert message.to_dict() == {"data": "hello"}
    imu = await talker.publisher("/imu", "sensor_msgs/Imu")
    with pytest.raises(SerializationError, match=r"has 7 fields \(header, orientation, .* by name"):
        imu.publish(3.0)


async def test_times_are_now_or_seconds(talker: TypedGraph, listener: TypedGraph) -> None:
    publisher = await talker.publisher("/r", "sensor_msgs/Range", latch=True)
    publisher.publish(header={"stamp": "now", "frame_id": "a"}, range=1.5)
    message = await listener.wait_for_message("/r", timeout_s=60)
    assert abs(message.header.stamp.to_s() - listener.now().to_s()) < 60
    again = publisher.codec.decode(publisher.codec.encode(message.to_dict()))
    assert again == message
    publisher.publish(header={"stamp": 12.5})
    assert (await listener.wait_for_message("/r", timeout_s=60)).header.stamp.to_s() == 12.5
    for wrong in ("soon", -1.0, float("nan"), True):
        with pytest.raises(SerializationError, match="needs a time"):
            publisher.publish(header={"stamp": wrong})


async def test_callbacks_get_messages_until_closed(talker: TypedGraph, listener: TypedGraph) -> None:
    received: list[str] = []

    def receive(message: Message) -> None:
        received.append(message.data)
        if message.data == "bad":
            raise ValueError

    publisher = await talker.publisher("/chatter", "std_msgs/String")
    subscriber = await listener.subscriber("/chatter", "std_msgs/String", receive)
    assert await publisher.wait_for_subscriber(60)
    for text in ("one", "bad", "two"):
        publisher.publish(text)
    async with asyncio.timeout(60):
        while received != ["one", "bad", "two"]:
            await asyncio.sleep(0.005)
        await subscriber.close()
        while publisher.subscriber_count:
            await asyncio.sleep(0.005)
    with pytest.raises(UnknownTypeError):
        await listener.subscriber("/chatter", "std_msgs/Strng", receive)


async def test_a_subscriber_with_an_illegal_name(listener: TypedGraph) -> None:
    with pytest.raises(InvalidNameError):
        await listener.subscriber("/left-wheel", "std_msgs/String", print)


async def test_anext_returns_one_message_after_the_other(talker: TypedGraph, listener: TypedGraph) -> None:
    publisher = await talker.publisher("/chatter", "std_msgs/String")
    stream = listener.messages("/chatter")
    first = asyncio.create_task(anext(stream))
    assert await publisher.wait_for_subscriber(60)
    publisher.publish("one")
    publisher.publish("two")
    assert [(await first).data, (await anext(stream)).data] == ["one", "two"]
    await stream.aclose()
    async with asyncio.timeout(60):
        while publisher.subscriber_count:
            await asyncio.sleep(0.005)


async def test_waiting_for_a_topic_without_publisher_is_logged(
    listener: TypedGraph, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("rostether.graph.message_stream.SILENCE_WARNING_S", 0.0)
    waiting = asyncio.create_task(listener.wait_for_message("/nothing"))
    async with asyncio.timeout(60):
        while "waiting for a message of /nothing, which has no publisher" not in caplog.text:
            await asyncio.sleep(0.005)
    waiting.cancel()


async def test_log_methods_have_the_names_of_a_device(talker: TypedGraph, listener: TypedGraph) -> None:
    received: list[int] = []
    subscriber = await listener.subscriber("/rosout", None, lambda message: received.append(message.level))
    async with asyncio.timeout(60):
        while len(received) < 3:
            talker.logwarn("careful")
            await asyncio.sleep(0.01)
    assert set(received) == {4}
    await subscriber.close()


async def test_async_callbacks_are_awaited_one_after_the_other(
    talker: TypedGraph, listener: TypedGraph
) -> None:
    received: list[str] = []

    async def receive(message: Message) -> None:
        received.append(f"{message.data} begins")
        await asyncio.sleep(0)
        received.append(f"{message.data} ends")

    publisher = await talker.publisher("/chatter", "std_msgs/String")
    subscriber = await listener.subscriber("/chatter", "std_msgs/String", receive)
    assert await publisher.wait_for_subscriber(60)
    publisher.publish("one")
    publisher.publish("two")
    async with asyncio.timeout(60):
        while len(received) < 4:
            await asyncio.sleep(0.005)
    assert received == ["one begins", "one ends", "two begins", "two ends"]
    await subscriber.close()


async def test_a_missing_message_is_named_in_the_error(listener: TypedGraph) -> None:
    with pytest.raises(TimeoutError, match=r"no message on /nothing within 0\.01 s"):
        await listener.wait_for_message("/nothing", timeout_s=0.01)


async def test_a_service_is_called_with_fields(talker: TypedGraph, listener: TypedGraph) -> None:
    await talker.service_server("/enable", "std_srvs/SetBool", lambda asked: {"success": asked.data})
    assert (await listener.call("/enable", "std_srvs/SetBool", data=True)).success is True
