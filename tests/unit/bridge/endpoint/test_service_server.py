from __future__ import annotations

import asyncio

import pytest
from msgspec.structs import replace

from rostether.bridge.endpoint import service_server as service_server_endpoint
from rostether.bridge.endpoint.service_server import ServiceServerEndpoint
from rostether.bridge.settings import BridgeSettings
from rostether.errors import ServiceCallError, ServiceTimeoutError
from rostether.rosserial.events import ServiceRole
from unit.bridge.doubles import FakeLine
from unit.bridge.nodes import STORE, World, service
from unit.bridge.virtual_time import on_virtual_time
from waiting import until

TYPE = STORE.registry.service_type("std_srvs/SetBool")
YES, NO = b"\x01", b"\x00"
DONE = b"\x01\x02\0\0\0ok"


def endpoint(world: World, *, timeout_s: float = 5.0, queued_calls: int = 32) -> ServiceServerEndpoint:
    return ServiceServerEndpoint(
        service(ServiceRole.SERVER),
        STORE,
        world.board,
        world.notices,
        BridgeSettings(service_timeout_s=timeout_s, queued_calls=queued_calls),
    )


@pytest.fixture
async def world() -> World:
    return await World().open()


def requests(line: FakeLine) -> int:
    return line.transport.written.count(b"110:")


async def test_a_call_reaches_the_board_and_its_response_the_caller(world: World) -> None:
    line, switch = FakeLine(), endpoint(world)
    switch.attach(line, switch.info)
    await switch.open()
    call = asyncio.ensure_future(world.peer.call_service("/switch", TYPE, YES))
    await until(lambda: line.transport.written, "the request")
    assert line.transport.written == b"110:\x01;"
    line.receivers[111]([DONE])
    assert await call == DONE
    assert switch.message_count == 1


async def test_one_call_is_in_flight_the_others_wait_their_turn(world: World) -> None:
    line, switch = FakeLine(), endpoint(world)
    switch.attach(line, switch.info)
    calls = [asyncio.ensure_future(switch.call(payload)) for payload in (YES, NO, YES)]
    for number in range(3):
        await until(lambda expected=number + 1: requests(line) == expected, f"request {number}")  # type: ignore[misc]
        await asyncio.sleep(0)
        assert requests(line) == number + 1
        line.receivers[111]([b"\x01\x01\0\0\0%d" % number])
    assert [await call for call in calls] == [b"\x01\x01\0\0\0%d" % number for number in range(3)]
    assert line.transport.written == b"110:\x01;110:\x00;110:\x01;"


async def test_more_callers_than_may_wait_are_refused_immediately(world: World) -> None:
    line, switch = FakeLine(), endpoint(world, queued_calls=2)
    switch.attach(line, switch.info)
    calls = [asyncio.ensure_future(switch.call(YES)) for _ in range(3)]
    await until(lambda: requests(line), "the first request")
    with pytest.raises(ServiceCallError, match="the limit of calls that wait"):
        await switch.call(YES)
    for call in calls:
        call.cancel()
    await asyncio.wait(calls)


async def test_a_board_that_does_not_answer(world: World) -> None:
    line, switch = FakeLine(), endpoint(world, timeout_s=0.02)
    switch.attach(line, switch.info)
    with pytest.raises(ServiceTimeoutError, match=r"switch within 0\.02 s"):
        await switch.call(YES)
    assert len(world.reporter.having("did not answer")) == 1


@on_virtual_time
async def test_a_late_response_is_dropped() -> None:
    world = await World().open()
    line, switch = FakeLine(), endpoint(world, timeout_s=0.05)
    switch.attach(line, switch.info)
    with pytest.raises(ServiceTimeoutError):
        await switch.call(YES)
    second = asyncio.ensure_future(switch.call(NO))
    await asyncio.sleep(0.01)
    assert requests(line) == 1, "a second request would take the first one's response"
    line.receivers[111]([b"\x01\x04\0\0\0late"])
    await until(lambda: requests(line) == 2, "the second request")
    line.receivers[111]([DONE])
    assert await second == DONE
    assert switch.dropped_count == 1


@on_virtual_time
async def test_a_board_that_was_silent_for_a_call_and_asks_for_the_time_again_gets_the_next() -> None:
    world = await World().open()
    line, switch, loop = FakeLine(), endpoint(world, timeout_s=0.05), asyncio.get_running_loop()
    switch.attach(line, switch.info)
    switch.time_requested(loop.time())
    with pytest.raises(ServiceTimeoutError):
        await switch.call(YES)
    second = asyncio.ensure_future(switch.call(NO))
    switch.time_requested(loop.time() + service_server_endpoint.BUSY_S)
    await until(lambda: requests(line) == 2, "the second request")
    line.receivers[111]([DONE])
    assert await second == DONE


@on_virtual_time
async def test_a_board_that_requests_the_time_during_a_call_may_still_answer() -> None:
    world = await World().open()
    line, switch, loop = FakeLine(), endpoint(world, timeout_s=0.05), asyncio.get_running_loop()
    switch.attach(line, switch.info)
    with pytest.raises(ServiceTimeoutError):
        await switch.call(YES)
    second = asyncio.ensure_future(switch.call(NO))
    now_s = loop.time()
    for asked in range(5):
        switch.time_requested(now_s + 2.5 * asked)
    await asyncio.sleep(0.01)
    assert requests(line) == 1, "a second request would take the first one's response"
    line.receivers[111]([b"\x01\x04\0\0\0late"])
    await until(lambda: requests(line) == 2, "the second request")
    line.receivers[111]([DONE])
    assert await second == DONE


async def test_a_board_that_stays_silent_is_busy_for_the_next_caller(world: World) -> None:
    line, switch = FakeLine(), endpoint(world, timeout_s=0.02)
    switch.attach(line, switch.info)
    with pytest.raises(ServiceTimeoutError, match="did not answer"):
        await switch.call(YES)
    with pytest.raises(ServiceTimeoutError, match="still busy with an earlier call"):
        await switch.call(YES)
    assert requests(line) == 1


@on_virtual_time
async def test_a_silent_board_serves_calls_again_after_the_quarantine() -> None:
    world = await World().open()
    line, switch = FakeLine(), endpoint(world, timeout_s=2 * service_server_endpoint.QUARANTINE_S)
    switch.attach(line, switch.info)
    first = asyncio.ensure_future(switch.call(YES))
    await until(lambda: requests(line), "the request")
    first.cancel()
    second = asyncio.ensure_future(switch.call(YES))
    await until(lambda: requests(line) == 2, "the next request")
    line.receivers[111]([DONE])
    assert await second == DONE


async def test_a_caller_that_gives_up_does_not_hand_its_response_to_the_next(world: World) -> None:
    line, switch = FakeLine(), endpoint(world)
    switch.attach(line, switch.info)
    first = asyncio.ensure_future(switch.call(YES))
    await until(lambda: requests(line), "the request")
    first.cancel()
    second = asyncio.ensure_future(switch.call(NO))
    await asyncio.sleep(0.01)
    line.receivers[111]([b"\x01\x05\0\0\0first"])
    await until(lambda: requests(line) == 2, "the second request")
    line.receivers[111]([DONE])
    assert await second == DONE


async def test_a_damaged_response_fails_the_call(world: World) -> None:
    line, switch = FakeLine(), endpoint(world)
    switch.attach(line, switch.info)
    call = asyncio.ensure_future(switch.call(YES))
    await until(lambda: requests(line), "the request")
    line.receivers[111]([b"\x01\xff"])
    with pytest.raises(ServiceCallError, match="bad response"):
        await call
    assert switch.misfit_count == 1


async def test_a_malformed_request_never_reaches_the_board(world: World) -> None:
    line, switch = FakeLine(), endpoint(world)
    switch.attach(line, switch.info)
    with pytest.raises(ServiceCallError, match="bad request"):
        await switch.call(b"far too long")
    with pytest.raises(ServiceCallError, match="70000 bytes, but the board's buffer has only"):
        await switch.call(bytes(70_000))
    assert line.transport.written == b""


async def test_a_board_that_is_lost_fails_the_call_immediately(world: World) -> None:
    line, switch = FakeLine(), endpoint(world)
    switch.attach(line, switch.info)
    call = asyncio.ensure_future(switch.call(YES))
    await until(lambda: requests(line), "the request")
    switch.detach()
    with pytest.raises(ServiceCallError, match="lost during the call"):
        await call
    with pytest.raises(ServiceCallError, match="not connected"):
        await switch.call(YES)


async def test_after_it_came_back_the_board_is_called_again(world: World) -> None:
    old, new, switch = FakeLine(), FakeLine(), endpoint(world, timeout_s=1.0)
    switch.attach(old, switch.info)
    with pytest.raises(ServiceTimeoutError):
        await switch.call(YES)
    switch.attach(new, switch.info)
    call = asyncio.ensure_future(switch.call(YES))
    await until(lambda: requests(new), "the request")
    new.receivers[111]([DONE])
    assert await call == DONE


async def test_a_board_that_was_reset_fails_the_call_immediately(world: World) -> None:
    line, switch = FakeLine(), endpoint(world)
    switch.attach(line, switch.info)
    call = asyncio.ensure_future(switch.call(YES))
    await until(lambda: requests(line), "the request")
    switch.fail_call("reset")
    with pytest.raises(ServiceCallError, match="was reset during the call of switch"):
        await call
    again = asyncio.ensure_future(switch.call(YES))
    await until(lambda: requests(line) == 2, "the next request")
    line.receivers[111]([DONE])
    assert await again == DONE


async def test_a_board_that_has_not_announced_its_service_again_is_called_in_a_moment(world: World) -> None:
    line, switch = FakeLine(), endpoint(world)
    switch.attach(line, switch.info)
    line.link.refused.add(110)
    with pytest.raises(ServiceCallError, match="switch: the board was reset and has not announced it again"):
        await switch.call(YES)


async def test_a_request_larger_than_the_boards_buffer_names_the_service_and_the_limit(world: World) -> None:
    line, switch = FakeLine(), endpoint(world)
    info = replace(switch.info, request=replace(switch.info.request, buffer_size=0))
    switch.attach(line, info)
    with pytest.raises(
        ServiceCallError, match="switch: the request has 1 byte, but the board's buffer has only 0; enlarge"
    ):
        await switch.call(YES)
    assert line.transport.written == b""
    (reported,) = world.reporter.texts
    assert "switch" in reported


async def test_closing_leaves_the_graph(world: World) -> None:
    switch = endpoint(world)
    await switch.open()
    await switch.close()
    assert world.network.snapshot().services == {}
