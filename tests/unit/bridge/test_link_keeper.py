from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from rostether.bridge.link_keeper import LinkKeeper
from rostether.errors import TransportClosedError, TransportError, TransportOpenError
from rostether.transports import serial
from rostether.transports.address import Address, parse_address
from rostether.transports.serial import SerialPort
from rostether.transports.transport import Transport
from unit.bridge.doubles import FakeTransport, RecordingReporter, until


class Bench:
    """A keeper whose opening and serving are the test's."""

    def __init__(self, address: str) -> None:
        self.reporter = RecordingReporter()
        self.opened: list[str] = []
        self.errors: list[TransportError] = []
        self.served: list[str | None] = []
        self.lost: asyncio.Future[TransportError | None] = asyncio.get_running_loop().create_future()
        keeper = LinkKeeper(parse_address(address), self.open, self.serve, self.reporter)
        self.task = asyncio.ensure_future(keeper.run())

    async def open(self, address: Address) -> Transport:
        self.opened.append(str(address))
        if self.errors:
            raise self.errors.pop(0)
        return FakeTransport()

    async def serve(
        self, address: Address, transport: Transport, serial_number: str | None
    ) -> TransportError | None:
        self.served.append(serial_number)
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


async def test_a_port_is_told_by_its_usb_serial_number_and_found_under_another_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second, by_id = tmp_path / "ttyACM0", tmp_path / "ttyACM1", tmp_path / "usb-Arduino_7533-if00"
    first.touch()
    by_id.symlink_to(first)
    other = SerialPort(path=str(tmp_path / "ttyS0"), description="")
    ours = SerialPort(path=str(first), description="Uno", by_id=str(by_id), serial_number="7533")
    monkeypatch.setattr(serial, "list_ports", lambda: [other, ours])
    bench = Bench(str(first))
    await bench.serving(1)
    assert bench.served == ["7533"]
    first.unlink()
    by_id.unlink()
    second.touch()
    by_id.symlink_to(second)
    bench.lost.set_result(TransportClosedError("gone"))
    await bench.serving(2)
    assert bench.opened == [str(first), str(by_id)]
    await bench.end()


async def test_a_refusal_right_after_plugging_in_is_no_news(
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
    monkeypatch.setattr("rostether.bridge.link_keeper.SETTLE_S", 0.0)
    monkeypatch.setattr("rostether.bridge.link_keeper.MAX_RETRY_S", 0.1)
    port = tmp_path / "ttyACM0"
    port.touch()
    bench = Bench(str(port))
    bench.errors = [TransportOpenError("no permission; join the group dialout")] * 5
    await bench.serving(1)
    assert bench.reporter.having("no permission") == ["no permission; join the group dialout (trying again)"]
    await bench.end()
