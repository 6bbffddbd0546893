"""The set-up against simulated radios, whose answers follow the maker's manual, on a virtual clock."""

from __future__ import annotations

import pytest

from rostether.errors import ConfigError, TransportError, TransportTimeoutError
from rostether.simulation.xbee.air import AirConditions
from rostether.simulation.xbee.network import XbeeNetwork
from rostether.simulation.xbee.radio import SimulatedRadio
from rostether.simulation.xbee.registers import DIGIMESH, SERIES_1, SERIES_3, Model
from rostether.transports.memory import memory_pair
from rostether.transports.transport import Transport
from rostether.transports.xbee.set_up import BAUD_CODES, RadioFound, RadioSettings, set_up_radio
from unit.bridge.virtual_time import run as run_on_virtual_time

COORDINATOR = RadioSettings(0, is_coordinator=True)
LABEL = 0x0013A20040A1B2C3


class Bench:
    """A radio on a port that is opened at different speeds."""

    def __init__(self, model: Model = SERIES_1) -> None:
        self.network = XbeeNetwork(AirConditions(), model=model)
        _, radio_port = memory_pair()
        self.radio: SimulatedRadio = self.network.add_fresh(radio_port)
        self.reports: list[str] = []

    async def open_at(self, baud: int) -> Transport:
        port, radio_port = memory_pair()
        self.network.connect(self.radio, radio_port, host_baud=baud)
        return port

    async def set_up(self, settings: RadioSettings) -> tuple[RadioFound, list[str]]:
        return await set_up_radio(self.open_at, settings, self.reports.append)

    def registers(self, *names: str) -> list[int]:
        return [self.radio.registers[name] for name in names]


def test_a_new_radio_is_set_up_as_a_coordinator_and_then_for_a_board() -> None:
    async def main() -> None:
        bench = Bench()
        found, commands = await bench.set_up(COORDINATOR)
        assert (found.baud, found.firmware, found.kind) == (9600, 0x10EC, "series 1 or 2, 802.15.4")
        assert found.serial_number == bench.radio.serial_number
        assert " ".join(commands) == "RE AP2 CE1 MY0 RN1 BD6 ID1331 CHD DH0 DL0 RO5 WR"
        assert bench.registers("AP", "CE", "MY", "BD", "ID", "CH") == [2, 1, 0, 6, 0x1331, 0x0D]
        # Now it is in API mode at 57600 baud.
        found, commands = await bench.set_up(RadioSettings(0x2A, pan_id=0x1332, channel=0x0F))
        assert found.baud == 57600
        assert bench.registers("AP", "CE", "MY", "ID", "CH") == [0, 0, 0x2A, 0x1332, 0x0F]
        assert bench.reports[-1] == "Looking for an XBee at 57600 baud"
        # The settings survive a reset.
        bench.radio.registers.execute("FR", None)
        assert bench.registers("MY", "BD") == [0x2A, 6]

    run_on_virtual_time(main())


def test_a_radio_with_the_slowest_speed_is_found_again() -> None:
    async def main() -> None:
        bench = Bench()
        await bench.set_up(RadioSettings(1, baud=min(BAUD_CODES)))
        found, _ = await bench.set_up(COORDINATOR)
        assert found.baud == min(BAUD_CODES)

    run_on_virtual_time(main())


@pytest.mark.parametrize(
    ("model", "kind", "commands"),
    [
        (SERIES_3, "series 3, 802.15.4", "RE MYFFFF RN1 BD6 ID1331 CHD DH13A200 DL40A1B2C3 RO5 WR"),
        (DIGIMESH, "series 3, DigiMesh", "RE BD6 ID1331 CHD DH13A200 DL40A1B2C3 RO5 WR"),
    ],
)
def test_a_board_with_its_64_bit_address(model: Model, kind: str, commands: str) -> None:
    async def main() -> None:
        found, accepted = await Bench(model).set_up(RadioSettings(None, coordinator_address=LABEL))
        assert (found.kind, " ".join(accepted)) == (kind, commands)

    run_on_virtual_time(main())


def test_a_register_with_more_than_32_bits_counts_as_missing() -> None:
    async def main() -> None:
        bench = Bench()
        bench.radio.registers._set["VR"] = 16**1000
        found, _ = await bench.set_up(COORDINATOR)
        assert found.firmware == 0

    run_on_virtual_time(main())


def test_wrong_settings_and_missing_radios_are_reported() -> None:
    async def main() -> None:
        with pytest.raises(ConfigError, match="has no 16-bit address; give --to"):
            await Bench(DIGIMESH).set_up(RadioSettings(1))
        with pytest.raises(TransportError, match="refuses ATCHFF; check the value"):
            await Bench().set_up(RadioSettings(1, channel=0xFF))

        async def open_nothing(_baud: int) -> Transport:
            return memory_pair()[0]

        with pytest.raises(TransportTimeoutError, match="no XBee answers at 9600, 57600"):
            await set_up_radio(open_nothing, COORDINATOR, lambda _line: None)

    run_on_virtual_time(main())
