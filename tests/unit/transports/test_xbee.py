from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest

from rostether.errors import TransportClosedError, TransportOpenError
from rostether.mechanisms.backoff import Backoff
from rostether.transports.address import SerialAddress, XbeeAddress
from rostether.transports.memory import MemoryTransport, memory_pair
from rostether.transports.transport import Transport
from rostether.transports.xbee import XbeeListener
from rostether.transports.xbee_frame import encode_tx
from unit.transports.recorder import Arrivals, Recorder
from unit.transports.test_xbee_frame import rx_frame


class Coordinator:
    """The other end of the coordinator's serial port, and what opens it."""

    def __init__(self) -> None:
        self.opened: list[SerialAddress] = []
        self.missing = False
        self.radio: MemoryTransport
        self.air: Recorder

    async def open(self, address: SerialAddress) -> Transport:
        if self.missing:
            raise TransportOpenError(f"no serial port {address.path}")
        self.opened.append(address)
        port, self.radio = memory_pair()
        self.air = Recorder()
        self.radio.start(self.air)
        return port

    async def start(self, arrivals: Arrivals, *, peers: tuple[int, ...] = ()) -> XbeeListener:
        return await XbeeListener.start(
            XbeeAddress("/dev/radio", 9600, peers),
            arrivals,
            open_serial=self.open,
            backoff=Backoff(first_s=0.001, limit_s=0.005),
        )


@pytest.fixture
def arrivals() -> Arrivals:
    return Arrivals()


@pytest.fixture
def coordinator() -> Coordinator:
    return Coordinator()


@pytest.fixture
async def listener(coordinator: Coordinator, arrivals: Arrivals) -> AsyncIterator[XbeeListener]:
    listener = await coordinator.start(arrivals)
    yield listener
    await listener.close()


async def test_each_source_is_a_transport_of_its_own(
    listener: XbeeListener, coordinator: Coordinator, arrivals: Arrivals
) -> None:
    assert coordinator.opened == [SerialAddress("/dev/radio", 9600)]
    coordinator.radio.write(rx_frame(1, b"one") + rx_frame(2, b"two") + rx_frame(1, b"more"))
    first, first_seen = await arrivals.next_started()
    second, second_seen = await arrivals.next_started()
    await first_seen.until_received(b"onemore")
    await second_seen.until_received(b"two")
    assert (first.peer, second.peer) == ("xbee 0x0001 at /dev/radio", "xbee 0x0002 at /dev/radio")
    first.write(b"\x7e to one")
    await coordinator.air.until_received(encode_tx(1, b"\x7e to one"))


async def test_long_writes_become_packets_of_a_hundred_bytes(
    listener: XbeeListener, coordinator: Coordinator, arrivals: Arrivals
) -> None:
    coordinator.radio.write(rx_frame(0x2A, b"x"))
    board = await arrivals.next()
    data = bytes(range(250))
    board.write(data)
    await coordinator.air.until_received(
        encode_tx(0x2A, data[:100]) + encode_tx(0x2A, data[100:200]) + encode_tx(0x2A, data[200:])
    )


async def test_peers_named_beforehand_are_there_at_once(coordinator: Coordinator, arrivals: Arrivals) -> None:
    listener = await coordinator.start(arrivals, peers=(3, 4))
    assert [(await arrivals.next()).peer[:11] for _ in range(2)] == ["xbee 0x0003", "xbee 0x0004"]
    listener.peers.expire(1e9)
    assert len(listener.peers) == 2
    await listener.close()


async def test_an_unplugged_coordinator_ends_all_and_comes_back(
    listener: XbeeListener, coordinator: Coordinator, arrivals: Arrivals
) -> None:
    coordinator.radio.write(rx_frame(1, b"x"))
    board, seen = await arrivals.next_started()
    coordinator.missing = True
    coordinator.radio.close()
    assert isinstance(await seen.until_lost(), TransportClosedError)
    board.write(b"into the void")
    await asyncio.sleep(0.02)
    assert len(coordinator.opened) == 1
    gone = coordinator.radio
    coordinator.missing = False
    async with asyncio.timeout(60):
        while coordinator.radio is gone:
            await asyncio.sleep(0.002)
    coordinator.radio.write(rx_frame(1, b"again"))
    _, seen_again = await arrivals.next_started()
    await seen_again.until_received(b"again")


async def test_a_port_that_is_not_there_is_reported_by_start(
    coordinator: Coordinator, arrivals: Arrivals
) -> None:
    coordinator.missing = True
    with pytest.raises(TransportOpenError):
        await coordinator.start(arrivals)


async def test_close_ends_everything_even_while_the_coordinator_is_away(
    coordinator: Coordinator, arrivals: Arrivals
) -> None:
    listener = await coordinator.start(arrivals)
    coordinator.radio.write(rx_frame(1, b"x"))
    _, seen = await arrivals.next_started()
    coordinator.missing = True
    coordinator.radio.close()
    await seen.until_lost()
    await listener.close()
    await listener.close()
    assert len(coordinator.opened) == 1
