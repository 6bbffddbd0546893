"""A bridge and boards on a simulated radio network, on a virtual clock."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial

import pytest

from effort import effort
from rostether.bridge.settings import BoardNodes
from rostether.bridge.supervisor import Links, Supervisor
from rostether.errors import TransportError
from rostether.graph.memory_network import MemoryNetwork
from rostether.simulation.xbee.air import AirConditions
from rostether.simulation.xbee.counting_board import CountingBoard
from rostether.simulation.xbee.network import XbeeNetwork
from rostether.simulation.xbee.radio import SimulatedRadio
from rostether.simulation.xbee.registers import DIGIMESH, SERIES_1, SERIES_3, Model
from rostether.transports.address import Address, SerialAddress, XbeeAddress
from rostether.transports.memory import memory_pair
from rostether.transports.peers import PeerEntry
from rostether.transports.transport import Listener, Transport
from rostether.transports.xbee.frame import XbeeFrameDecoder, encode_frame
from rostether.transports.xbee.listener import XbeeListener
from unit.bridge.nodes import STORE
from unit.bridge.virtual_time import run as run_on_virtual_time

COUNT = STORE.registry.message_type("std_msgs/UInt32")
LED = STORE.registry.message_type("std_msgs/Bool")


class Radios:
    """A bridge with its radio, and boards with theirs; `received` are the numbers of each board's topic."""

    def __init__(self, conditions: AirConditions, model: Model, *, diagnostics: bool) -> None:
        self.xbees = XbeeNetwork(conditions, model=model, seed=1)
        self.network = MemoryNetwork()
        self.supervisor = Supervisor(
            self.network.join,
            STORE,
            nodes=BoardNodes(diagnostics=diagnostics),
            links=Links(listen=self.listen),
        )
        self.boards: list[CountingBoard] = []
        self.radios: list[SimulatedRadio] = []
        self.received: dict[str, list[int]] = {}
        self.port, radio_port = memory_pair()
        self.coordinator = self.xbees.add_coordinator(radio_port)

    async def listen(
        self,
        address: Address,
        on_transport: Callable[[Transport], None],
        *,
        entry: PeerEntry | None = None,
    ) -> Listener:
        assert isinstance(address, XbeeAddress)
        assert entry is not None
        return await XbeeListener.start(address, on_transport, open_serial=self.open, call=entry.call)

    async def open(self, address: SerialAddress) -> Transport:
        return self.port

    def board(self, number: int, *, is_short: bool, rate_hz: float) -> CountingBoard:
        board_port, radio_port = memory_pair()
        short_address = number if is_short else None
        self.radios.append(self.xbees.add_board(radio_port, self.coordinator, short_address=short_address))
        board = CountingBoard(f"board_{number}", board_port, rate_hz=rate_hz, store=STORE)
        self.boards.append(board)
        self.received[board.name] = []
        return board

    def radio_of(self, number: int) -> SimulatedRadio:
        return self.radios[number - 1]

    def set_registers(self, **values: int) -> None:
        for radio in (self.coordinator, *self.radios):
            for name, value in values.items():
                radio.registers.execute(name, value)
            radio.registers.apply()


def _collect(numbers: list[int], payloads: list[bytes]) -> None:
    numbers.extend(struct.unpack("<I", each)[0] for each in payloads)


@asynccontextmanager
async def radios(
    count: int,
    conditions: AirConditions,
    *,
    model: Model = SERIES_1,
    rate_hz: float = 5.0,
    is_short: bool = True,
    diagnostics: bool = False,
) -> AsyncIterator[Radios]:
    site = Radios(conditions, model, diagnostics=diagnostics)
    peer = await site.network.join("/peer")
    async with AsyncExitStack() as stack:
        for number in range(1, count + 1):
            board = await stack.enter_async_context(site.board(number, is_short=is_short, rate_hz=rate_hz))
            numbers = site.received[board.name]
            await peer.subscribe(f"/{board.name}/count", COUNT, partial(_collect, numbers))
        await site.supervisor.start([XbeeAddress("/dev/radio", 57600)])
        stack.push_async_callback(site.supervisor.close)
        yield site
    site.xbees.close()


@pytest.mark.parametrize(
    ("model", "is_short", "mac_mode"),
    [(SERIES_1, True, 0), (SERIES_1, True, 1), (SERIES_3, False, 2), (DIGIMESH, False, None)],
    ids=["series 1", "no acknowledgements", "64-bit addresses", "DigiMesh"],
)
def test_eight_boards_with_losses_and_repeats_all_send(
    model: Model, is_short: bool, mac_mode: int | None
) -> None:
    # A board whose first packets were lost is called again after 2 s.
    begin_s, measured_s, rate_hz = 14, effort(4, 60), 5.0

    async def main() -> None:
        conditions = AirConditions(loss=0.05, repeat=0.02, delay_s=0.01)
        async with radios(8, conditions, model=model, rate_hz=rate_hz, is_short=is_short) as site:
            if mac_mode is not None:
                site.set_registers(MM=mac_mode)
            driver = await site.network.join("/driver")
            leds = [await driver.advertise(f"/{board.name}/led", LED) for board in site.boards]
            await asyncio.sleep(begin_s)
            for numbers in site.received.values():
                numbers.clear()
            changes = [board.led_changes for board in site.boards]
            for turn in range(4 * measured_s):
                for led in leds:
                    led.publish_raw([bytes((turn % 2,))])
                await asyncio.sleep(0.25)
            for board, before in zip(site.boards, changes, strict=True):
                assert len(set(site.received[board.name])) >= measured_s * rate_hz * 0.6, board.name
                assert board.led_changes - before >= measured_s, board.name
                assert board.connected

    run_on_virtual_time(main())


def test_a_board_out_of_reach_does_not_delay_others() -> None:
    async def main() -> None:
        async with radios(3, AirConditions(), rate_hz=20.0) as site:
            await asyncio.sleep(2.0)
            site.radio_of(1).registers.execute("CH", 0x0F)
            site.radio_of(1).registers.apply()
            driver = await site.network.join("/driver")
            leds = [await driver.advertise(f"/{board.name}/led", LED) for board in site.boards]
            before = [board.led_changes for board in site.boards]
            for turn in range(100):
                for led in leds:
                    led.publish_raw([bytes((turn % 2,))])
                await asyncio.sleep(0.05)
            changes = [board.led_changes - start for board, start in zip(site.boards, before, strict=True)]
            assert changes[0] == 0
            assert min(changes[1:]) >= 95
            lost = next(view for view in site.supervisor.boards() if view.node == "/xbee_0x0001")
            assert lost.is_connected

    run_on_virtual_time(main())


def test_link_quality_is_on_diagnostics() -> None:
    async def main() -> None:
        async with radios(1, AirConditions(rssi_dbm=-71), diagnostics=True) as site:
            peer = await site.network.join("/monitor")
            arrays: list[bytes] = []
            kind = STORE.registry.message_type("diagnostic_msgs/DiagnosticArray")
            await peer.subscribe("/diagnostics", kind, arrays.extend)
            await asyncio.sleep(6.0)
            status = STORE.codec("diagnostic_msgs/DiagnosticArray").decode(arrays[-1]).status[0]
            values = {each.key: each.value for each in status.values}
            assert status.hardware_id == "xbee 0x0001"
            assert values["signal [dBm]"] == "-71"
            assert values["last radio packet"] == "delivered"
            assert int(values["radio packets sent"]) > 2
            assert values["radio packets lost"] == "0"
            site.xbees.air.conditions = AirConditions(loss=0.7, rssi_dbm=-71)
            driver = await site.network.join("/driver")
            led = await driver.advertise("/board_1/led", LED)
            for _ in range(100):
                led.publish_raw([b"\x01"])
                await asyncio.sleep(0.05)
            await asyncio.sleep(1.5)
            status = STORE.codec("diagnostic_msgs/DiagnosticArray").decode(arrays[-1]).status[0]
            finding = next(each.value for each in status.values if each.key == "finding radio-loss")
            assert "no acknowledgement, signal -71 dBm" in finding
            # The board is out of range: one finding, with one remedy.
            site.radio_of(1).registers.execute("ID", 0x1234)
            site.radio_of(1).registers.apply()
            await asyncio.sleep(8.0)
            status = STORE.codec("diagnostic_msgs/DiagnosticArray").decode(arrays[-1]).status[0]
            findings = {each.key: each.value for each in status.values if each.key.startswith("finding ")}
            assert list(findings) == ["finding board-silent"]
            assert "check its power and its radio" in findings["finding board-silent"]

    run_on_virtual_time(main())


def test_closing_stops_every_board() -> None:
    async def main() -> None:
        async with radios(8, AirConditions()) as site:
            await asyncio.sleep(3.0)
            assert all(board.connected for board in site.boards)
            await site.supervisor.close()
            await asyncio.sleep(0.2)
            assert not any(board.connected for board in site.boards)

    run_on_virtual_time(main())


class HeardFrames:
    """The host of a radio: keeps the frames that the radio sends."""

    def __init__(self) -> None:
        self.frames: list[bytes] = []
        self._decoder = XbeeFrameDecoder()

    def data_received(self, data: bytes) -> None:
        self.frames += self._decoder.feed(data)

    def connection_lost(self, error: TransportError | None) -> None:
        pass

    def pause_writing(self) -> None:
        pass

    def resume_writing(self) -> None:
        pass


@pytest.mark.parametrize("model", [SERIES_1, DIGIMESH], ids=["series 1", "DigiMesh"])
def test_at_commands_reach_other_radios(model: Model) -> None:
    def frame(number: int, long: int, short: int, command: bytes) -> bytes:
        addresses = long.to_bytes(8, "big") + short.to_bytes(2, "big")
        return encode_frame(bytes((0x17, number)) + addresses + b"\x02" + command)

    async def main() -> None:
        xbees = XbeeNetwork(AirConditions(), model=model)
        host, radio_port = memory_pair()
        coordinator = xbees.add_coordinator(radio_port)
        board = xbees.add_board(memory_pair()[1], coordinator, short_address=None if model.is_mesh else 7)
        arrived = HeardFrames()
        host.start(arrived)
        answers = arrived.frames
        short = b"\xff\xfe" if model.is_mesh else b"\x00\x07"
        source = board.serial_number.to_bytes(8, "big") + short

        async def ask(data: bytes) -> None:
            host.write(data)
            await asyncio.sleep(1)

        await ask(frame(1, board.serial_number, 0xFFFE, b"CH"))
        await ask(frame(2, board.serial_number, 0xFFFE, b"RO\x09"))
        await ask(frame(3, board.serial_number, 0xFFFE, b"XX"))
        # No radio has this address.
        await ask(frame(4, board.serial_number + 1, 0xFFFE, b"CH"))
        assert answers == [
            b"\x97\x01" + source + b"CH\x00\x0d",
            b"\x97\x02" + source + b"RO\x00",
            b"\x97\x03" + source + b"XX\x02",
            b"\x97\x04" + (board.serial_number + 1).to_bytes(8, "big") + b"\xff\xfeCH\x04",
        ]
        assert board.registers["RO"] == 9
        if not model.is_mesh:
            await ask(frame(5, 0xFFFFFFFFFFFFFFFF, 7, b"MY"))
            assert answers[-1] == b"\x97\x05" + source + b"MY\x00\x00\x07"
        xbees.close()

    run_on_virtual_time(main())
