from __future__ import annotations

import queue
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager

import pytest

import rostether.sync
from rostether.errors import UnknownNameError
from rostether.msg.std_msgs import Bool
from rostether.rosserial.events import TopicRole
from rostether.serde.values import Message
from rostether.srv.std_srvs import SetBool
from rostether.sync.blocking import LOOP, OpenContext
from rostether.transports.opening import listen
from unit.device.host import Host, Hosts

TIMEOUT_S = 60.0


@asynccontextmanager
async def listening(hosts: Hosts) -> AsyncIterator[str]:
    listener = await listen("tcp://127.0.0.1:0", hosts)
    yield listener.address
    await listener.close()
    await hosts.close()


async def _hosts() -> Hosts:
    return Hosts()


@pytest.fixture
def line() -> Iterator[tuple[rostether.sync.Device, Host]]:
    hosts = LOOP.call(_hosts())
    with OpenContext(lambda: listening(hosts)) as address, rostether.sync.Device(address.wrapped) as device:
        yield device, LOOP.call(hosts.next())


def test_topics_parameters_and_logs(line: tuple[rostether.sync.Device, Host]) -> None:
    device, host = line
    count = device.publisher("count", "std_msgs/UInt32")
    got: queue.Queue[Message] = queue.Queue()
    device.subscriber("led", "std_msgs/Bool", got.put)
    device.wait_connected(timeout_s=TIMEOUT_S)
    assert device.connected
    LOOP.call(host.until(lambda: ("led", TopicRole.SUBSCRIBER) in host.announced))
    assert count.publish(7)
    assert count.publish_many([device.message("std_msgs/UInt32", data=8)])
    count.drained(TIMEOUT_S)
    device.loginfo("ready")
    LOOP.call(host.until(lambda: bool(host.logs) and len(host.messages["count"]) == 2))
    assert [message.data for message in host.messages["count"]] == [7, 8]
    LOOP.loop.call_soon_threadsafe(host.publish, "led", {"data": True})
    assert got.get(timeout=TIMEOUT_S).data is True
    switches = device.messages("switch", Bool)
    LOOP.call(host.until(lambda: ("switch", TopicRole.SUBSCRIBER) in host.announced))
    LOOP.loop.call_soon_threadsafe(host.publish, "switch", {"data": True})
    assert next(switches).data is True
    host.params["gain"] = ((3,), (), ())
    assert device.get_param("gain") == 3
    with pytest.raises(UnknownNameError):
        device.get_param("missing")
    assert device.now().secs >= 0


def test_a_device_offers_and_calls_services(line: tuple[rostether.sync.Device, Host]) -> None:
    device, host = line
    host.answers["add"] = lambda request: {"success": request.data}
    client = device.service_client("add", SetBool)
    # A handler may call in turn: it does not run in the loop.
    device.service_server(
        "enable", SetBool, lambda request: {"success": client.call(data=request.data).success}
    )
    device.wait_connected(timeout_s=TIMEOUT_S)
    LOOP.call(host.until(lambda: {"add", "enable"} <= host.services.keys()))
    assert LOOP.call(host.call("enable", {"data": True})).success is True


def test_a_loop_over_messages_ends_when_the_device_is_closed(
    line: tuple[rostether.sync.Device, Host],
) -> None:
    device, _ = line
    switches = device.messages("switch", Bool)
    device.close()
    assert list(switches) == []
