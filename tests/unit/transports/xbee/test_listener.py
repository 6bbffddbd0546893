from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest

from rostether.errors import TransportOpenError
from rostether.transports.address import SerialAddress, XbeeAddress
from rostether.transports.memory import MemoryTransport, memory_pair
from rostether.transports.peers import PeerTransport
from rostether.transports.transport import Transport
from rostether.transports.xbee.frame import XbeeFrameDecoder, encode_frame
from rostether.transports.xbee.listener import ANSWER_LIMIT_S, XbeeListener
from rostether.transports.xbee.send_queue import QUEUE_LIMIT_BYTES
from unit.bridge.virtual_time import run as run_on_virtual_time
from unit.transports.recorder import Arrivals
from unit.transports.xbee.test_frame import rx_frame
from waiting import until

MESH_RADIO = {"AP": b"\x02", "NH": b"\x07", "NP": b"\x00\x49", "DB": b"\x2d"}
SERIES_1 = {"AP": b"\x02"}


class Coordinator:
    """The radio at the host: answers AT commands and reports each packet; silent if `mute`."""

    def __init__(self) -> None:
        self.opened: list[SerialAddress] = []
        self.missing = False
        self.mute = False
        self.registers = SERIES_1
        self.status = 0
        # Destination and payload of what was sent.
        self.sent: list[tuple[int, bytes]] = []
        self.radio: MemoryTransport

    async def open(self, address: SerialAddress) -> Transport:
        if self.missing:
            raise TransportOpenError(f"no serial port {address.path}")
        self.opened.append(address)
        port, self.radio = memory_pair()
        self.decoder = XbeeFrameDecoder()
        self.radio.start(self)
        return port

    async def start(
        self, arrivals: Arrivals, *, peers: tuple[int, ...] = (), call: bytes = b""
    ) -> XbeeListener:
        return await XbeeListener.start(
            XbeeAddress("/dev/radio", 9600, peers),
            arrivals,
            open_serial=self.open,
            call=call,
        )

    def data_received(self, data: bytes) -> None:
        for frame in self.decoder.feed(data):
            if frame[0] == 0x08:
                value = self.registers.get(frame[2:4].decode())
                answer = b"\x02" if value is None else b"\x00" + value
                self.answer(b"\x88" + frame[1:4] + answer)
            elif frame[0] == 0x10:
                self.sent.append((int.from_bytes(frame[2:10], "big"), frame[14:]))
                self.answer(bytes((0x8B, frame[1], 0xFF, 0xFE, 3, self.status, 0)))
            else:
                size = 8 if frame[0] == 0x00 else 2
                self.sent.append((int.from_bytes(frame[2 : 2 + size], "big"), frame[3 + size :]))
                self.answer(bytes((0x89, frame[1], self.status)))

    def answer(self, data: bytes) -> None:
        if not self.mute:
            self.radio.write(encode_frame(data))

    def connection_lost(self, error: Exception | None) -> None: ...

    def pause_writing(self) -> None: ...

    def resume_writing(self) -> None: ...


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


async def test_each_source_has_a_separate_transport(
    listener: XbeeListener, coordinator: Coordinator, arrivals: Arrivals
) -> None:
    assert coordinator.opened == [SerialAddress("/dev/radio", 9600)]
    coordinator.radio.write(rx_frame(1, b"one") + rx_frame(2, b"two") + rx_frame(1, b"more"))
    first, first_seen = await arrivals.next_started()
    second, second_seen = await arrivals.next_started()
    await first_seen.until_received(b"onemore")
    await second_seen.until_received(b"two")
    assert (first.peer, second.peer) == ("xbee 0x0001", "xbee 0x0002")
    first.write(b"\x7e to one")
    await until(lambda: coordinator.sent == [(1, b"\x7e to one")], "the packet")


async def test_long_writes_become_packets_of_a_hundred_bytes(
    listener: XbeeListener, coordinator: Coordinator, arrivals: Arrivals
) -> None:
    coordinator.radio.write(rx_frame(0x2A, b"x"))
    board = await arrivals.next()
    data = bytes(range(250))
    board.write(data)
    packets = [(0x2A, data[:100]), (0x2A, data[100:200]), (0x2A, data[200:])]
    await until(lambda: coordinator.sent == packets, "the packets")


async def test_peers_of_the_address_exist_at_the_start(coordinator: Coordinator, arrivals: Arrivals) -> None:
    listener = await coordinator.start(arrivals, peers=(3, 4))
    assert [(await arrivals.next()).peer for _ in range(2)] == ["xbee 0x0003", "xbee 0x0004"]
    listener.peers.now_s = lambda: 1e9
    listener.peers.expire()
    assert len(listener.peers) == 2
    await listener.close()


async def test_an_unplugged_coordinator_ends_all_and_comes_back(
    listener: XbeeListener, coordinator: Coordinator, arrivals: Arrivals
) -> None:
    coordinator.radio.write(rx_frame(1, b"x"))
    board, seen = await arrivals.next_started()
    coordinator.missing = True
    coordinator.radio.close()
    assert str(await seen.until_lost()).startswith("xbee 0x0001 is out of reach: xbee:")
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


async def test_start_reports_a_port_that_does_not_exist(coordinator: Coordinator, arrivals: Arrivals) -> None:
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


async def test_a_board_that_sends_while_it_closes_gets_no_transport(
    coordinator: Coordinator, arrivals: Arrivals
) -> None:
    coordinator.status = 1
    listener = await coordinator.start(arrivals, peers=(1,))
    (await arrivals.next()).write(b"x" * 300)
    await until(lambda: bool(coordinator.sent), "a packet")
    closing = asyncio.create_task(listener.close())
    await asyncio.sleep(0)
    listener.data_received(rx_frame(2, b"late"))
    await closing
    assert (arrivals.count, len(listener.peers)) == (1, 0)


async def test_a_forged_broadcast_address_is_not_a_board(
    listener: XbeeListener, coordinator: Coordinator, arrivals: Arrivals
) -> None:
    everyone = encode_frame(b"\x80" + b"\xff" * 8 + b"\x28\x00x")
    coordinator.radio.write(rx_frame(0xFFFF, b"x") + rx_frame(0xFFFE, b"x") + everyone + rx_frame(1, b"x"))
    assert (await arrivals.next()).peer == "xbee 0x0001"


async def test_a_mesh_has_its_own_frames_and_shorter_packets(
    coordinator: Coordinator, arrivals: Arrivals
) -> None:
    coordinator.registers = MESH_RADIO
    label = 0x0013A20040A1B2C3
    listener = await coordinator.start(arrivals, peers=(label,))
    board = await arrivals.next()
    assert board.peer == "xbee 0013a20040a1b2c3"
    board.write(bytes(80))
    await until(lambda: coordinator.sent == [(label, bytes(73)), (label, bytes(7))], "the packets")
    coordinator.answer(b"\x90" + label.to_bytes(8, "big") + b"\xff\xfe\x01" + b"hello")
    assert isinstance(board, PeerTransport)
    quality = board.quality
    assert quality is not None
    await until(lambda: quality.rssi_dbm == -45, "the answer to DB")
    await until(lambda: quality.sent_packets == 2, "the reports")
    assert (quality.received_packets, quality.lost_packets, quality.retries) == (1, 0, 6)
    await listener.close()


async def test_packets_without_acknowledgement_are_counted(
    coordinator: Coordinator, arrivals: Arrivals
) -> None:
    coordinator.status = 1
    listener = await coordinator.start(arrivals, peers=(7,))
    board = await arrivals.next()
    board.write(b"x")
    assert isinstance(board, PeerTransport)
    quality = board.quality
    assert quality is not None
    await until(lambda: quality.lost_packets == 1, "the report")
    assert quality.last_status == "no acknowledgement"
    coordinator.radio.write(rx_frame(7, b"I am here"))
    await until(lambda: quality.rssi_dbm == -0x28, "the packet")
    await listener.close()


async def test_bytes_for_a_full_queue_are_counted_as_lost(
    listener: XbeeListener, coordinator: Coordinator, arrivals: Arrivals
) -> None:
    coordinator.mute = True
    coordinator.radio.write(rx_frame(1, b"x"))
    board = await arrivals.next()
    assert isinstance(board, PeerTransport)
    quality = board.quality
    assert quality is not None
    board.write(bytes(QUEUE_LIMIT_BYTES))
    assert quality.lost_packets == 0
    board.write(bytes(QUEUE_LIMIT_BYTES))
    assert (quality.lost_packets, quality.last_status) == (1, "queue full")


async def test_a_broadcast_calls_boards(coordinator: Coordinator, arrivals: Arrivals) -> None:
    listener = await coordinator.start(arrivals, call=b"\xff\x00")
    await until(lambda: coordinator.sent == [(0xFFFF, b"\xff\x00")], "the call")
    await listener.close()
    # Boards that are given need no call.
    quiet = await coordinator.start(arrivals, peers=(1,), call=b"\xff\x00")
    (await arrivals.next()).write(b"x")
    await until(lambda: coordinator.sent[1:] == [(1, b"x")], "the packet")
    await quiet.close()


@pytest.mark.parametrize(
    ("mode", "mute", "text"),
    [(b"\x01", False, "is not in API mode 2"), (b"\x02", True, "does not answer at 9600 baud")],
)
def test_a_radio_in_another_mode_is_reported(
    mode: bytes, mute: bool, text: str, caplog: pytest.LogCaptureFixture
) -> None:
    async def main() -> None:
        coordinator = Coordinator()
        coordinator.registers, coordinator.mute = {"AP": mode}, mute
        listener = await coordinator.start(Arrivals())
        await asyncio.sleep(2 * ANSWER_LIMIT_S)
        await listener.close()

    run_on_virtual_time(main())
    assert [text in record.getMessage() for record in caplog.records] == [True]
    assert "rostether xbee setup /dev/radio --coordinator" in caplog.text
