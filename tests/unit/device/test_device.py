from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, assert_type

import pytest

import rostether
from loop_watch import FolderWatch
from rostether.device import Device
from rostether.errors import (
    ConfigError,
    LocalProtocolError,
    SerializationError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    TransportClosedError,
    TransportTimeoutError,
    UnknownNameError,
    UnknownTypeError,
)
from rostether.mechanisms.backoff import Backoff
from rostether.msg.std_msgs import Bool, UInt32
from rostether.rosserial.device_link import DeviceLinkConfig
from rostether.rosserial.events import TopicRole
from rostether.rosserial.packets import LogLevel
from rostether.serde.values import Message
from rostether.srv.std_srvs import SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerResponse
from rostether.transports.memory import memory_pair
from rostether.transports.opening import listen, open_transport
from unit.device.host import HOST_TIME, STORE, Host, Hosts, hosting
from waiting import until


def quick() -> Backoff:
    return Backoff(first_s=0.001, limit_s=0.01)


def device_on(link: Any, **options: Any) -> Device:
    return Device(link, store=STORE, backoff=quick(), **options)


@asynccontextmanager
async def tethered(device: Device, line: Any) -> AsyncIterator[Host]:
    async with hosting(line) as host, device:
        yield host


@pytest.fixture
async def pair() -> AsyncIterator[tuple[Device, Any]]:
    near, far = memory_pair()
    yield device_on(near), far


async def test_publish_messages_mappings_and_fields(pair: tuple[Device, Any]) -> None:
    device, line = pair
    publisher = device.publisher("count", "std_msgs/UInt32")
    assert publisher.publish(data=0) is False
    async with tethered(device, line) as host:
        await device.wait_connected()
        assert device.connected
        assert publisher.publish(data=1)
        assert publisher.publish({"data": 2})
        assert publisher.publish(STORE.codec("std_msgs/UInt32").message_class(data=3))
        assert publisher.publish_many([{"data": 4}, {"data": 5}])
        await host.until(lambda: len(host.messages["count"]) == 5)
        assert [message.data for message in host.messages["count"]] == [1, 2, 3, 4, 5]
        assert host.announced["count", TopicRole.PUBLISHER].info.message_type == "std_msgs/UInt32"
    assert not device.connected
    assert publisher.publish(data=6) is False


async def test_a_loop_over_messages_ends_when_the_device_is_closed(pair: tuple[Device, Any]) -> None:
    device, line = pair
    messages = device.messages("in", UInt32)
    got: list[int] = []

    async def collect() -> None:
        async for message in messages:
            got.append(message.data)

    async with tethered(device, line) as host:
        collecting = asyncio.create_task(collect())
        await host.until(lambda: ("in", TopicRole.SUBSCRIBER) in host.announced)
        host.publish("in", {"data": 1})
        await until(lambda: got == [1])
    async with asyncio.timeout(10):
        await collecting
    assert got == [1]


async def test_messages_that_do_not_fit_are_refused_before_they_are_sent(pair: tuple[Device, Any]) -> None:
    device, line = pair
    count = device.publisher("count", "std_msgs/UInt32")
    text = device.publisher("text", "std_msgs/String")
    async with tethered(device, line):
        await device.wait_connected()
        with pytest.raises(SerializationError, match="data"):
            count.publish(data=-1)
        with pytest.raises(SerializationError, match="no field"):
            count.publish(dat=1)
        with pytest.raises(SerializationError, match="give one of them"):
            count.publish({"data": 1}, data=2)
        with pytest.raises(LocalProtocolError, match="65535"):
            text.publish(data="x" * 65535)
        with pytest.raises(UnknownTypeError):
            device.publisher("x", "nobody_msgs/Nothing")


async def test_the_largest_frame_is_sent_and_received(pair: tuple[Device, Any]) -> None:
    device, line = pair
    got: list[Message] = []
    text = device.publisher("out", "std_msgs/String")
    device.subscriber("in", "std_msgs/String", got.append)
    async with tethered(device, line) as host:
        await device.wait_connected()
        assert text.publish(data="x" * 65531)
        await host.until(
            lambda: bool(host.messages["out"]) and ("in", TopicRole.SUBSCRIBER) in host.announced
        )
        host.publish("in", {"data": "y" * 65531})
        await until(lambda: bool(got))
    assert len(host.messages["out"][0].data) == len(got[0].data) == 65531


async def test_subscribe_and_survive_a_callback_that_fails(
    pair: tuple[Device, Any], caplog: pytest.LogCaptureFixture
) -> None:
    device, line = pair
    got: list[int] = []

    def callback(message: Message) -> None:
        got.append(message.data)
        if message.data == 1:
            raise RuntimeError("broken program")

    subscriber = device.subscriber("in", "std_msgs/Int16", callback)
    async with tethered(device, line) as host:
        await host.until(lambda: host.settled)
        info = host.announced["in", TopicRole.SUBSCRIBER].info
        for value in (1, 2):
            host.publish("in", {"data": value})
        host.transport.write(host.link.encode_message(info.topic_id, b"\1\2\3"))
        host.publish("in", {"data": 3})
        await until(lambda: got == [1, 2, 3])
    assert subscriber.received_count == 3
    assert "the callback of in failed" in caplog.text


async def test_serve_calls_in_order_with_plain_and_async_handlers(pair: tuple[Device, Any]) -> None:
    device, line = pair

    async def slow_shout(request: Message) -> dict[str, Any]:
        await asyncio.sleep(0)
        return {"output": request.input.upper()}

    def ignore(_request: Message) -> None:
        return None

    device.service_server("shout", "rosserial_arduino/Test", slow_shout)
    device.service_server("ignore", "std_srvs/Trigger", ignore)
    async with tethered(device, line) as host:
        await host.until(lambda: {"shout", "ignore"} <= set(host.services))
        assert (await host.call("shout", {"input": "hello"})).output == "HELLO"
        assert (await host.call("shout", {"input": "again"})).output == "AGAIN"
        assert (await host.call("ignore", {})).success is False


async def test_types_as_classes(pair: tuple[Device, Any]) -> None:
    device, line = pair

    def enable(request: SetBoolRequest) -> SetBoolResponse:
        return SetBoolResponse(success=not request.data)

    # With `await`, as on a graph, and without.
    count = await device.publisher("count", UInt32)
    device.service_server("enable", SetBool, enable)
    lookup = device.service_client("lookup", Trigger)
    switches = device.messages("switch", Bool, queue_size=2)
    async with tethered(device, line) as host:
        host.answers["lookup"] = lambda _request: {"message": "found"}
        await host.until(lambda: {"enable", "lookup"} <= set(host.services))
        await host.until(lambda: ("switch", TopicRole.SUBSCRIBER) in host.announced)
        assert count.publish(data=3)
        if TYPE_CHECKING:
            count.publish(dta=3)  # type: ignore[call-overload]
        assert (await host.call("enable", {"data": True})).success is False
        assert_type(await lookup.call(), TriggerResponse)
        for value in (True, True, False):
            host.publish("switch", {"data": value})
        received = await anext(switches)
        assert_type(received, Bool)
        assert isinstance(received, Bool)
        assert [received.data, (await anext(switches)).data] == [True, False]
        assert switches.dropped_count == 1


async def test_a_handler_that_fails_is_logged_on_the_host_and_the_next_call_works(
    pair: tuple[Device, Any], caplog: pytest.LogCaptureFixture
) -> None:
    device, line = pair
    turns = iter([ValueError("no such arm"), SerializationError("bad value"), None])

    def handler(_request: Message) -> dict[str, Any]:
        if (error := next(turns)) is not None:
            raise error
        return {"output": "fine"}

    device.service_server("arm", "rosserial_arduino/Test", handler)
    async with tethered(device, line) as host:
        await host.until(lambda: "arm" in host.services)
        request = host.services["arm"].request.topic_id
        for _ in range(2):
            host.transport.write(host.link.encode_message(request, bytes(4)))
        await host.until(lambda: len(host.logs) == 2)
        assert [log.text for log in host.logs] == [
            "service arm failed: ValueError: no such arm",
            "service arm failed: bad value",
        ]
        assert all(log.level is LogLevel.ERROR for log in host.logs)
        assert (await host.call("arm", {})).output == "fine"


async def test_call_services_one_at_a_time(pair: tuple[Device, Any]) -> None:
    device, line = pair
    client = device.service_client("lookup", "rosserial_arduino/Test")
    async with tethered(device, line) as host:
        host.answers["lookup"] = lambda request: {"output": request.input[::-1]}
        answers = await asyncio.gather(*(client.call(input=f"{number}a") for number in range(5)))
        assert [answer.output for answer in answers] == [f"a{number}" for number in range(5)]
        assert (await client.call({"input": "xy"})).output == "yx"


async def test_an_unanswered_call_ends_and_a_late_answer_is_dropped(pair: tuple[Device, Any]) -> None:
    device, line = pair
    client = device.service_client("lookup", "rosserial_arduino/Test")
    async with tethered(device, line) as host:
        host.answers["lookup"] = lambda _request: None
        await device.wait_connected()
        with pytest.raises(ServiceTimeoutError, match=r"lookup did not answer within 0\.05 s"):
            await client.call(input="a", timeout_s=0.05)
        late = STORE.codec("rosserial_arduino/TestResponse").encode({"output": "late"})
        host.transport.write(host.link.encode_message(host.services["lookup"].response.topic_id, late))
        await asyncio.sleep(0.01)
        host.answers["lookup"] = lambda _request: {"output": "in time"}
        assert (await client.call(input="b")).output == "in time"


async def test_a_call_waits_for_a_host_as_long_as_its_limit() -> None:
    near, far = memory_pair()
    async with device_on(near) as device:
        client = device.service_client("lookup", "rosserial_arduino/Test")
        with pytest.raises(ServiceTimeoutError):
            await client.call(input="a", timeout_s=0.02)
    far.close()


async def test_a_lost_line_fails_pending_calls_and_parameters(pair: tuple[Device, Any]) -> None:
    device, line = pair
    client = device.service_client("lookup", "rosserial_arduino/Test")
    async with tethered(device, line) as host:
        host.answers_params = False
        await device.wait_connected()
        call = asyncio.ensure_future(client.call(input="a"))
        param = asyncio.ensure_future(device.get_param("~rate", timeout_s=60))
        await host.until(
            lambda: len(host.events) > 0 and any("ParameterRequested" in repr(e) for e in host.events)
        )
        host.transport.close()
        with pytest.raises(ServiceUnavailableError, match="line to the host was lost"):
            await call
        with pytest.raises(TransportTimeoutError, match="line to the host was lost"):
            await param


async def test_get_parameters_of_every_kind(pair: tuple[Device, Any]) -> None:
    device, line = pair
    async with tethered(device, line) as host:
        host.params = {
            "~int": ((7,), (), ()),
            "~float": ((), (0.5,), ()),
            "~text": ((), (), ("hello",)),
            "~ints": ((1, 2), (), ()),
            "~texts": ((), (), ("a", "b")),
        }
        values = await asyncio.gather(*(device.get_param(name) for name in host.params))
        assert values == [7, 0.5, "hello", [1, 2], ["a", "b"]]
        with pytest.raises(UnknownNameError, match="no parameter ~nothing"):
            await device.get_param("~nothing")
        assert await device.get_param("~nothing", 2.5) == 2.5
        host.answers_params = False
        with pytest.raises(TransportTimeoutError, match="~int"):
            await device.get_param("~int", timeout_s=0.05)
        host.answers_params = True
        assert await device.get_param("~int") == 7


async def test_logs_and_time(pair: tuple[Device, Any]) -> None:
    device, line = pair
    async with tethered(device, line) as host:
        for log in (device.logdebug, device.loginfo, device.logwarn, device.logerror, device.logfatal):
            log(f"text of {log.__name__}")
        await host.until(lambda: len(host.logs) == 5)
        assert [log.level for log in host.logs] == list(LogLevel)
        await until(lambda: device.now().secs >= HOST_TIME.secs)
        assert device.now().secs < HOST_TIME.secs + 60


async def test_a_host_that_stops_is_disconnected_until_it_requests_the_topics_again(
    pair: tuple[Device, Any],
) -> None:
    device, line = pair
    publisher = device.publisher("count", "std_msgs/UInt32")
    async with tethered(device, line) as host:
        await host.until(lambda: host.settled)
        host.stop()
        await until(lambda: not device.connected)
        assert publisher.publish(data=1) is False
        with pytest.raises(TransportTimeoutError, match="rostether serve"):
            await device.wait_connected(timeout_s=0.01)


async def test_a_long_wait_for_a_host_names_its_cause(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("rostether.device.device.NO_HOST_WARNING_S", 0.0)
    cause = "no program listens on 127.0.0.1:1"
    async with device_on("tcp://127.0.0.1:1") as device:
        with pytest.raises(TransportTimeoutError, match=cause):
            await device.wait_connected(timeout_s=0.1)
    assert [record.getMessage() for record in caplog.records if record.levelname == "WARNING"] == [
        f"no host has requested the topics yet: {cause}; start it, or correct the port"
    ]


async def test_endpoints_declared_while_connected_reach_the_host(pair: tuple[Device, Any]) -> None:
    device, line = pair
    async with tethered(device, line) as host:
        await host.until(lambda: host.settled)
        got: list[Message] = []
        device.subscriber("late_in", "std_msgs/Empty", got.append)
        await host.until(lambda: ("late_in", TopicRole.SUBSCRIBER) in host.announced)
        host.publish("late_in", {})
        await until(lambda: bool(got))
        device.publisher("late_out", "std_msgs/Empty").publish()
        await host.until(lambda: bool(host.messages["late_out"]))
        device.service_server("late_ask", "std_srvs/Trigger", lambda _request: {"success": True})
        await host.until(lambda: "late_ask" in host.services)
        assert (await host.call("late_ask", {})).success


async def test_a_flood_is_slowed_down_by_a_host_that_does_not_read_and_loses_nothing() -> None:
    near, far = memory_pair()
    device = device_on(near)
    publisher = device.publisher("flood", "std_msgs/UInt32")
    async with hosting(far) as host, device:
        await host.until(lambda: host.settled)
        far.pause_reading()
        sent = 0
        while publisher.publish(data=sent):
            sent += 1
            if sent % 100 == 0:
                await asyncio.sleep(0)
        assert sent > 100
        far.resume_reading()
        await host.until(lambda: len(host.messages["flood"]) == sent)
        await publisher.drained(60)
        assert [message.data for message in host.messages["flood"]] == list(range(sent))
        assert publisher.publish(data=sent)


@pytest.mark.parametrize("scheme", ["tcp", "udp"])
async def test_reconnect_to_a_host_that_starts_late_and_restarts(scheme: str) -> None:
    hosts = Hosts()
    probe = await listen(f"{scheme}://:0", hosts)
    address = probe.address
    await probe.close()
    device = device_on(address)
    publisher = device.publisher("count", "std_msgs/UInt32")
    async with device:
        await asyncio.sleep(0.02)
        assert not device.connected
        for turn in range(2 if scheme == "tcp" else 1):
            listener = await listen(address, hosts)
            host = await hosts.next()
            await device.wait_connected(timeout_s=60)
            publisher.publish(data=turn)
            await host.until(lambda host=host: bool(host.messages["count"]))  # type: ignore[misc]
            assert host.messages["count"][0].data == turn
            await host.close()
            await listener.close()
    await hosts.close()


async def test_messages_arrive_again_when_a_closed_device_is_opened_again() -> None:
    hosts = Hosts()
    listener = await listen("tcp://:0", hosts)
    device = device_on(listener.address)
    messages = device.messages("in", UInt32)
    for value in (1, 2):
        async with device:
            host = await hosts.next()
            await host.until(lambda host=host: ("in", TopicRole.SUBSCRIBER) in host.announced)  # type: ignore[misc]
            host.publish("in", {"data": value})
            async with asyncio.timeout(60):
                assert (await anext(messages)).data == value
        await host.close()
    await listener.close()
    await hosts.close()


async def test_tether_over_a_pseudo_terminal(tmp_path: Path) -> None:
    line = await open_transport(f"pty:{tmp_path}/board")
    device = device_on(f"{tmp_path}/board")
    publisher = device.publisher("count", "std_msgs/UInt32")
    async with hosting(line) as host, device:
        await device.wait_connected(timeout_s=60)
        publisher.publish_many({"data": number} for number in range(5000))
        await host.until(lambda: len(host.messages["count"]) == 5000)


async def test_make_the_pseudo_terminal_that_the_host_opens(tmp_path: Path) -> None:
    async with device_on(f"pty:{tmp_path}/board") as device:
        device.publisher("count", "std_msgs/UInt32")
        async with hosting(await open_transport(f"{tmp_path}/board")) as host:
            await device.wait_connected(timeout_s=60)
            await host.until(lambda: ("count", TopicRole.PUBLISHER) in host.announced)


async def test_a_device_can_have_the_limits_of_a_small_board() -> None:
    near, far = memory_pair()
    device = device_on(near, config=DeviceLinkConfig(version=1, max_publishers=1, output_buffer_bytes=24))
    publisher = device.publisher("text", "std_msgs/String")
    with pytest.raises(LocalProtocolError):
        device.publisher("more", "std_msgs/String")
    async with hosting(far) as host, device:
        await device.wait_connected(timeout_s=60)
        with pytest.raises(LocalProtocolError, match="room for 16"):
            publisher.publish(data="x" * 13)
        publisher.publish(data="x" * 12)
        await host.until(lambda: bool(host.messages["text"]))
        assert host.link.version == 1


async def test_a_device_opens_one_line() -> None:
    with pytest.raises(ConfigError, match="accepts many devices"):
        Device("xbee:/dev/x", store=STORE)
    with pytest.raises(ConfigError, match="unknown option"):
        Device("tcp://:1?speed=1", store=STORE)


async def test_closing_twice_is_harmless(pair: tuple[Device, Any]) -> None:
    device, line = pair
    async with tethered(device, line):
        await device.close()
    await device.close()


def test_the_package_exports_it() -> None:
    assert rostether.Device is Device
    with pytest.raises(AttributeError, match="Divice"):
        _ = rostether.Divice


async def test_no_folder_is_listed_on_the_event_loop(tmp_path: Path) -> None:
    folder = tmp_path / "my_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Mine.msg").write_text("int32 x\n")
    mine, _ = memory_pair()
    watch = FolderWatch()
    async with Device(mine, msg_paths=[tmp_path], backoff=quick()) as device:
        device.publisher("mine", "my_msgs/Mine")
        device.publisher("chatter", "std_msgs/String")
        device.subscriber("other", "my_msgs/Mine", lambda _: None)
        with pytest.raises(UnknownTypeError):
            device.publisher("none", "my_msgs/None")
    assert watch.listed == []


async def test_an_async_callback_is_refused(pair: tuple[Device, Any]) -> None:
    async def receive(_: Message) -> None: ...

    with pytest.raises(TypeError, match="write a plain function"):
        pair[0].subscriber("chatter", "std_msgs/String", receive)
    nothing: Any = None
    with pytest.raises(TypeError, match="the handler must be a function"):
        pair[0].service_server("switch", "std_srvs/SetBool", nothing)


async def test_a_closed_device_ends_the_waits_for_a_host(pair: tuple[Device, Any]) -> None:
    device, _ = pair
    client = device.service_client("lookup", "rosserial_arduino/Test")
    async with device:
        connected = asyncio.ensure_future(device.wait_connected())
        call = asyncio.ensure_future(client.call(input="a", timeout_s=60))
        param = asyncio.ensure_future(device.get_param("~rate", timeout_s=60))
        await asyncio.sleep(0)
        await asyncio.sleep(0)
    with pytest.raises(TransportClosedError, match="the device was closed"):
        await connected
    with pytest.raises(ServiceUnavailableError, match="service lookup: the device was closed"):
        await call
    with pytest.raises(TransportTimeoutError, match="parameter ~rate: the device was closed"):
        await param


async def test_a_closed_device_fails_pending_calls(pair: tuple[Device, Any]) -> None:
    device, line = pair
    client = device.service_client("lookup", "rosserial_arduino/Test")
    async with tethered(device, line):
        await device.wait_connected()
        call = asyncio.ensure_future(client.call(input="a"))
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        await device.close()
        with pytest.raises(ServiceUnavailableError, match="the device was closed"):
            await call


async def test_without_a_host_calls_and_parameters_name_the_reason() -> None:
    device = Device("/dev/no-such-port")
    client = device.service_client("lookup", "rosserial_arduino/Test")
    async with device:
        with pytest.raises(
            ServiceTimeoutError, match=r"within 0\.05 s: no host is connected: no serial port"
        ):
            await client.call(input="a", timeout_s=0.05)
        with pytest.raises(TransportTimeoutError, match=r"parameter ~rate within 0\.05 s: no serial port"):
            await device.get_param("~rate", timeout_s=0.05)
