from __future__ import annotations

import asyncio
from typing import ClassVar

import pytest

from rostether.bridge.endpoint.service_client import MAX_WAITING_REQUESTS, ServiceClientEndpoint
from rostether.bridge.settings import BridgeSettings
from rostether.errors import InvalidNameError, ServiceCallError
from rostether.graph.memory_network import MemoryGraph
from rostether.msgdef.interface import ServiceType
from rostether.ros2.listed_client import ListedClient
from rostether.rosserial.events import ServiceRole
from unit.bridge.doubles import FakeLine
from unit.bridge.nodes import STORE, World, service
from waiting import until

TYPE = STORE.registry.service_type("std_srvs/SetBool")
YES = b"\x01"
DONE = b"\x01\x02\0\0\0ok"
ZERO = b"\x00\0\0\0\0"


def endpoint(world: World, *, timeout_s: float = 5.0, name: str = "switch") -> ServiceClientEndpoint:
    return ServiceClientEndpoint(
        service(ServiceRole.CLIENT, name),
        STORE,
        world.board,
        world.notices,
        BridgeSettings(client_call_timeout_s=timeout_s),
    )


@pytest.fixture
async def world() -> World:
    return await World().open()


async def test_the_boards_call_reaches_the_service_and_its_response_the_board(world: World) -> None:
    asked: list[bytes] = []

    async def answer(request: bytes) -> bytes:
        asked.append(request)
        return DONE

    await world.peer.advertise_service("/switch", TYPE, answer)
    line, client = FakeLine(), endpoint(world)
    client.attach(line, client.info)
    line.receivers[110]([YES])
    await until(lambda: line.transport.written, "the response")
    assert line.transport.written == b"111:" + DONE + b";"
    assert asked == [YES]
    assert client.message_count == 1
    assert (line.calls_started, line.calls_finished) == (1, 1)


async def test_time_answers_wait_from_the_moment_of_the_request(world: World) -> None:
    line, client = FakeLine(), endpoint(world)
    client.attach(line, client.info)
    line.receivers[110]([YES])
    assert line.calls_started == 1


async def test_a_defect_loses_one_response_and_is_one_line(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def answer(request: bytes) -> bytes:
        return DONE

    async def fail(*_: object, **__: object) -> bytes:
        raise KeyError("call")

    await world.peer.advertise_service("/switch", TYPE, answer)
    line, client = FakeLine(), endpoint(world)
    client.attach(line, client.info)
    with monkeypatch.context() as defective:
        defective.setattr(MemoryGraph, "call_service", fail)
        line.receivers[110]([YES])
        await until(lambda: line.transport.written, "the empty response")
    line.receivers[110]([YES])
    await until(lambda: line.transport.written.endswith(DONE + b";"), "the response")
    assert line.transport.written == b"111:" + ZERO + b";111:" + DONE + b";"
    assert (line.calls_started, line.calls_finished) == (2, 2)
    (reported,) = world.reporter.texts
    assert "KeyError: 'call'; please report it; the board gets an empty response" in reported


@pytest.mark.parametrize("failure", ["nobody", "refuses", "hangs", "malformed"])
async def test_a_call_that_fails_still_gets_a_response(world: World, failure: str) -> None:
    async def answer(request: bytes) -> bytes:
        if failure == "refuses":
            raise ServiceCallError("the gripper is stuck")
        if failure == "hangs":
            await asyncio.sleep(60.0)
        return b"\xff"

    if failure != "nobody":
        await world.peer.advertise_service("/switch", TYPE, answer)
    line, client = FakeLine(), endpoint(world, timeout_s=0.05)
    client.attach(line, client.info)
    line.receivers[110]([YES])
    await until(lambda: line.transport.written, "the response")
    assert line.transport.written == b"111:" + ZERO + b";"
    (reported,) = world.reporter.having("switch")
    assert "the board gets an empty response" in reported
    assert ("gripper" in reported) == (failure == "refuses")
    await until(lambda: line.calls_finished == 1, "the end of the call")


async def test_calls_are_answered_in_their_order(world: World) -> None:
    async def answer(request: bytes) -> bytes:
        await asyncio.sleep(0.01 if request == YES else 0.0)
        return request + b"\0\0\0\0"

    await world.peer.advertise_service("/switch", TYPE, answer)
    line, client = FakeLine(), endpoint(world)
    client.attach(line, client.info)
    line.receivers[110]([YES, b"\0"])
    await until(lambda: line.transport.written.count(b"111:") == 2, "both responses")
    assert line.transport.written == b"111:\x01\0\0\0\0;111:\0\0\0\0\0;"


async def test_a_damaged_request_is_answered_because_the_board_may_wait(world: World) -> None:
    line, client = FakeLine(), endpoint(world)
    client.attach(line, client.info)
    line.receivers[110]([b"\x01\x02\x03"])
    await until(lambda: line.transport.written, "a response")
    assert line.transport.written == b"111:" + ZERO + b";"
    assert client.misfit_count == 1


async def test_a_response_that_does_not_fit_is_replaced(world: World) -> None:
    async def answer(request: bytes) -> bytes:
        return b"\x01\x04\x01\0\0" + b"x" * 260

    await world.peer.advertise_service("/switch", TYPE, answer)
    line, client = FakeLine(), endpoint(world)
    client.attach(line, client.info)
    line.link.limit_bytes = 100
    line.receivers[110]([YES])
    await until(lambda: line.transport.written, "the response")
    assert line.transport.written == b"111:" + ZERO + b";"
    assert len(world.reporter.having("switch")) == 1


async def test_a_flood_of_requests_is_bounded(world: World) -> None:
    line, client = FakeLine(), endpoint(world)
    client.attach(line, client.info)
    line.receivers[110]([YES] * 1000)
    assert client.dropped_count == 1000 - MAX_WAITING_REQUESTS
    await until(lambda: line.calls_finished == MAX_WAITING_REQUESTS, "the calls")


async def test_a_board_that_is_lost_gets_no_response(world: World) -> None:
    called = asyncio.Event()

    async def answer(request: bytes) -> bytes:
        called.set()
        await asyncio.sleep(60.0)
        return DONE

    await world.peer.advertise_service("/switch", TYPE, answer)
    line, client = FakeLine(), endpoint(world)
    client.attach(line, client.info)
    line.receivers[110]([YES])
    await called.wait()
    client.detach()
    assert line.receivers == {}
    await until(lambda: line.calls_finished == 1, "the end of the call")
    assert line.transport.written == b""


async def test_an_illegal_name_is_reported_at_setup(world: World) -> None:
    with pytest.raises(InvalidNameError):
        await endpoint(world, name="no spaces").open()
    await endpoint(world).open()
    await endpoint(world).close()


class ListingGraph(MemoryGraph):
    """A graph that lists clients, as ROS 2 does."""

    clients: ClassVar[list[str]] = []

    async def list_client(self, service: str, service_type: ServiceType) -> ListedClient:
        entry = f"{self.resolve(service)} {service_type.name}"
        self.clients.append(entry)

        async def withdraw() -> None:
            self.clients.remove(entry)

        return ListedClient(withdraw)


async def test_a_client_is_listed_from_its_announcement_until_it_is_closed(world: World) -> None:
    world.board.__class__ = ListingGraph
    client = endpoint(world)
    client.attach(FakeLine(), client.info)
    await client.open()
    assert ListingGraph.clients == ["/switch std_srvs/SetBool"]
    client.detach()
    assert len(ListingGraph.clients) == 1, "it stays for the board that comes back"
    await client.close()
    await client.close()
    assert ListingGraph.clients == []
