from __future__ import annotations

import asyncio
import os
import sys
from pathlib import Path

import pytest

from rostether.bridge.ports.link_keeper import LinkKeeper
from rostether.errors import TransportClosedError, TransportError, TransportOpenError
from rostether.ports.board_identity import BoardIdentity
from rostether.ports.device_book import DeviceBook
from rostether.ports.devices_toml import parse_devices_toml
from rostether.transports.address import Address, SerialAddress
from rostether.transports.address_parser import parse_address
from rostether.transports.serial_port import SerialPort
from rostether.transports.transport import Transport
from unit.bridge.doubles import FakeTransport, RecordingReporter
from waiting import until


class Bench:
    """A keeper whose functions for opening and serving are the test's."""

    def __init__(self, address: str, devices: DeviceBook | None = None) -> None:
        self.reporter = RecordingReporter()
        self.opened: list[str] = []
        self.errors: list[TransportError] = []
        self.served: list[BoardIdentity] = []
        self.ports: list[SerialPort] = []
        self.addresses: list[Address] = []
        self.lost: asyncio.Future[TransportError | None] = asyncio.get_running_loop().create_future()
        keeper = LinkKeeper(
            parse_address(address),
            self.open,
            self.serve,
            self.reporter,
            devices or DeviceBook(),
            lambda: self.ports,
        )
        self.task = asyncio.ensure_future(keeper.run())

    async def open(self, address: Address) -> Transport:
        self.opened.append(str(address))
        self.addresses.append(address)
        if self.errors:
            raise self.errors.pop(0)
        return FakeTransport()

    async def serve(
        self, address: Address, transport: Transport, identity: BoardIdentity
    ) -> TransportError | None:
        self.served.append(identity)
        self.lost = asyncio.get_running_loop().create_future()
        return await self.lost

    async def serving(self, times: int) -> None:
        await until(lambda: len(self.served) == times, f"link number {times}")

    async def end(self) -> None:
        self.task.cancel()
        await asyncio.wait([self.task])


async def test_a_lost_link_is_opened_again(tmp_path: Path) -> None:
    port = tmp_path / "ttyACM0"
    port.touch()
    bench = Bench(f"{port}?baud=115200")
    await bench.serving(1)
    bench.lost.set_result(TransportClosedError("the board is gone; plug it in again"))
    await bench.serving(2)
    assert bench.reporter.texts == [
        f"Connecting to {port} at 115200 baud",
        "the board is gone; plug it in again",
        f"Connecting to {port} at 115200 baud",
    ]
    await bench.end()


@pytest.mark.parametrize("mark", [{"serial_number": "7533"}, {"usb_location": "1-1.2:1.0"}])
async def test_a_board_is_reported_by_serial_number_or_socket_and_found_under_another_number(
    mark: dict[str, str], tmp_path: Path
) -> None:
    first, second = tmp_path / "ttyACM0", tmp_path / "ttyACM1"
    first.touch()
    other = SerialPort(path=str(tmp_path / "ttyS0"), description="")
    bench = Bench(str(first))
    bench.ports = [other, SerialPort(str(first), "Uno", usb_vendor_id=1, usb_product_id=2, **mark)]  # type: ignore[arg-type]
    await bench.serving(1)
    assert (bench.served[0].serial_number or bench.served[0].usb_location) == next(iter(mark.values()))
    first.unlink()
    bench.ports = [other, SerialPort(str(second), "Uno", usb_vendor_id=1, usb_product_id=2, **mark)]  # type: ignore[arg-type]
    second.touch()
    bench.lost.set_result(TransportClosedError("gone"))
    await bench.serving(2)
    assert bench.opened == [str(first), str(second)]
    assert bench.served[0].key == bench.served[1].key
    # A board's node name comes from the address as it was given.
    assert bench.reporter.texts[-1] == f"Connecting to {second} at 57600 baud"
    await bench.end()


async def test_another_board_at_the_port_is_served_too(tmp_path: Path) -> None:
    port = tmp_path / "ttyACM0"
    port.touch()
    bench = Bench(str(port))
    for number, serial_number in enumerate(("7533", "8644"), 1):
        bench.ports = [SerialPort(str(port), "Uno", serial_number=serial_number)]
        await bench.serving(number)
        assert bench.served[-1].serial_number == serial_number
        bench.lost.set_result(TransportClosedError("gone"))
    await bench.end()


@pytest.mark.parametrize(("query", "baud"), [("", 115200), ("?baud=9600", 9600), ("?baud=57600", 57600)])
async def test_a_file_sets_the_speed_that_the_address_leaves_open(
    query: str, baud: int, tmp_path: Path
) -> None:
    port = tmp_path / "ttyACM0"
    port.touch()
    devices = parse_devices_toml(f'[devices.arm]\nport = "{port}"\nbaud = 115200\nreset = false\n')
    bench = Bench(f"{port}{query}", devices)
    await bench.serving(1)
    address = bench.addresses[0]
    assert isinstance(address, SerialAddress)
    assert (address.baud, address.reset) == (baud, False)
    await bench.end()


async def test_a_refusal_right_after_plugging_in_is_not_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    port = tmp_path / "ttyACM0"
    port.touch()
    bench = Bench(str(port))
    bench.errors = [TransportOpenError("no permission")] * 2
    await bench.serving(1)
    assert bench.reporter.texts == [f"Connecting to {port} at 57600 baud"]
    await bench.end()


async def test_a_refusal_that_lasts_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.bridge.ports.link_keeper.SETTLE_S", 0.0)
    monkeypatch.setattr("rostether.bridge.ports.link_keeper.MAX_RETRY_S", 0.1)
    port = tmp_path / "ttyACM0"
    port.touch()
    bench = Bench(str(port))
    bench.errors = [TransportOpenError("no permission; join the group dialout")] * 5
    await bench.serving(1)
    assert bench.reporter.having("no permission") == ["no permission; join the group dialout (trying again)"]
    await bench.end()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
async def test_a_terminal_whose_number_another_program_got_stays_closed() -> None:
    near, far = os.openpty()
    path = Path(os.ttyname(far))
    bench = Bench(str(path))
    await bench.serving(1)
    bench.lost.set_result(TransportClosedError(f"{path} is gone"))
    await bench.serving(2)
    made_ns = path.stat().st_ctime_ns

    def is_another() -> bool:
        # Like a terminal that was created later, this one now has a later time.
        path.chmod(0o600)
        return path.stat().st_ctime_ns != made_ns

    await until(is_another, "a later time")
    bench.lost.set_result(TransportClosedError(f"{path} is gone"))
    await until(lambda: bench.reporter.having("is now the terminal of another program"), "the line")
    assert len(bench.opened) == 2
    await bench.end()
    os.close(near)
    os.close(far)
