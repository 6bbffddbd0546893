"""Flashing, with a fake avrdude and with pseudo-terminals instead of boards."""

from __future__ import annotations

import os
import pty
import termios
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from msgspec.structs import replace

from rostether.errors import FirmwareError, RostetherError
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuiltFirmware
from rostether.firmware.upload import check_port, choose_port, touch, upload
from rostether.transports.serial_port import SerialPort
from unit.firmware.programs import FakeProgram
from unit.firmware.sketches import EMPTY, write_sketch

pytestmark = pytest.mark.avr


@pytest.fixture
def avrdude(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FakeProgram:
    (tmp_path / "bin").mkdir()
    return FakeProgram(tmp_path / "bin", "avrdude", monkeypatch)


@pytest.fixture
def terminal() -> Iterator[tuple[int, str]]:
    """A pseudo-terminal: the test's end, and the path of the board's port."""
    ours, theirs = pty.openpty()
    path = os.ttyname(theirs)
    os.close(theirs)
    yield ours, path
    os.close(ours)


async def build(tmp_path: Path, board: str, text: str = EMPTY) -> BuiltFirmware:
    return await build_sketch(write_sketch(tmp_path, "S", text), find_board(board))


def ports(*found: SerialPort) -> Callable[[], list[SerialPort]]:
    return lambda: list(found)


def usb(path: str, vendor: int, product: int) -> SerialPort:
    return SerialPort(path=path, description="a board", usb_vendor_id=vendor, usb_product_id=product)


@pytest.mark.parametrize(
    ("board", "mcu", "protocol", "baud"),
    [
        ("uno", "atmega328p", "arduino", "115200"),
        ("mega", "atmega2560", "wiring", "115200"),
        ("nano:atmega328old", "atmega328p", "arduino", "57600"),
    ],
)
async def test_avrdude_gets_the_board_and_the_port(
    tmp_path: Path,
    avrdude: FakeProgram,
    terminal: tuple[int, str],
    board: str,
    mcu: str,
    protocol: str,
    baud: str,
) -> None:
    built = await build(tmp_path, board)
    await upload(built, terminal[1])
    assert avrdude.calls == [
        [
            "-q",
            "-p",
            mcu,
            "-c",
            protocol,
            "-P",
            terminal[1],
            "-b",
            baud,
            "-D",
            "-U",
            f"flash:w:{built.image}:i",
        ]
    ]


@pytest.mark.parametrize(
    ("printed", "message"),
    [
        ("avrdude: stk500_getsync(): not in sync: resp=0x00", "no Arduino UNO answers on .*; check --board"),
        ("avrdude: can't open device: Permission denied", "no permission to open"),
        ("avrdude: can't open device: Device or resource busy", "is in use by another program"),
        ("avrdude: something else went wrong", "avrdude failed: avrdude: something else went wrong"),
    ],
)
async def test_the_reason_of_a_failure_is_one_line(
    tmp_path: Path, avrdude: FakeProgram, terminal: tuple[int, str], printed: str, message: str
) -> None:
    avrdude.behave(code=1, prints=f"avrdude: Version 7.1\n{printed}\n")
    with pytest.raises(RostetherError, match=message) as caught:
        await upload(await build(tmp_path, "uno"), terminal[1])
    assert "\n" not in str(caught.value)


async def test_a_missing_avrdude_is_reported(
    tmp_path: Path, terminal: tuple[int, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    built = await build(tmp_path, "uno")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FirmwareError, match="no avrdude on PATH; run: sudo apt install avrdude"):
        await upload(built, terminal[1])


async def test_the_simulated_network_is_not_flashed(tmp_path: Path, avrdude: FakeProgram) -> None:
    text = '#include <Ethernet.h>\nEthernetClient c;\nvoid setup() { c.connect("x", 1); }\nvoid loop() {}\n'
    with pytest.raises(FirmwareError, match="built with the Ethernet library of simulated boards"):
        await upload(await build(tmp_path, "uno", text), "/dev/null")
    assert avrdude.calls == []


def test_a_missing_port_is_reported() -> None:
    with pytest.raises(RostetherError, match="no serial port /dev/nowhere; no serial port found"):
        check_port("/dev/nowhere", ports())


def test_a_free_port_can_be_opened(terminal: tuple[int, str]) -> None:
    check_port(terminal[1], ports())


def test_a_port_in_use_names_its_user(terminal: tuple[int, str]) -> None:
    handle = os.open(terminal[1], os.O_RDWR | os.O_NOCTTY)
    try:
        with pytest.raises(FirmwareError, match="is in use by this program; close that program"):
            check_port(terminal[1], ports())
    finally:
        os.close(handle)


def test_a_port_that_is_not_on_usb_is_never_chosen() -> None:
    with pytest.raises(FirmwareError, match=r"no board found on USB; .* with --port \(/dev/ttyS0\)"):
        choose_port(find_board("uno"), ports(SerialPort("/dev/ttyS0", "onboard")))


def test_the_port_of_the_board_is_chosen_among_several() -> None:
    found = ports(
        SerialPort("/dev/ttyS0", "onboard"),
        usb("/dev/ttyUSB0", 0x1A86, 0x7523),
        usb("/dev/ttyACM0", 0x2341, 0x0043),
    )
    assert choose_port(find_board("uno"), found) == "/dev/ttyACM0"
    with pytest.raises(FirmwareError, match=r"several serial ports: .*ttyUSB0.*; choose one with --port"):
        choose_port(find_board("mega"), found)


def test_the_only_usb_port_is_chosen() -> None:
    found = ports(SerialPort("/dev/ttyS0", "onboard"), usb("/dev/ttyUSB0", 0x1A86, 0x7523))
    assert choose_port(find_board("nano"), found) == "/dev/ttyUSB0"


def test_without_a_port_the_error_has_a_hint() -> None:
    with pytest.raises(FirmwareError, match="no serial port found; plug in the board, or give its port"):
        choose_port(find_board("uno"), ports())


class Reappearing:
    """A port that disappears after a touch and returns, perhaps under another name."""

    def __init__(self, path: str, comes_back_as: str | None) -> None:
        there = [usb(path, 0x2341, 0x8036)]
        back = [usb(comes_back_as, 0x2341, 0x0036)] if comes_back_as else []
        self._looks = [there, there, [], *[back] * 1000]

    def __call__(self) -> list[SerialPort]:
        return self._looks.pop(0)


@pytest.mark.parametrize("name", [None, "/dev/ttyACM7"])
async def test_a_touch_opens_the_port_at_1200_baud_and_waits_for_the_boot_loader(
    terminal: tuple[int, str], name: str | None
) -> None:
    ours, path = terminal
    assert await touch(path, Reappearing(path, name or path)) == (name or path)
    assert termios.tcgetattr(ours)[4:6] == [termios.B1200, termios.B1200]


async def test_a_missing_boot_loader_is_reported(terminal: tuple[int, str]) -> None:
    with pytest.raises(
        FirmwareError, match=r"no bootloader answered .*; press the board's reset button twice"
    ):
        await touch(terminal[1], Reappearing(terminal[1], None), limit_s=0.5)


async def test_a_leonardo_is_touched_and_flashed_at_its_new_port(
    tmp_path: Path, avrdude: FakeProgram, terminal: tuple[int, str]
) -> None:
    built = await build(tmp_path, "leonardo")
    await upload(built, terminal[1], list_ports=Reappearing(terminal[1], "/dev/ttyACM9"))
    assert avrdude.calls[0][:8] == ["-q", "-p", "atmega32u4", "-c", "avr109", "-P", "/dev/ttyACM9", "-b"]


async def test_arduino_cli_can_flash_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "bin").mkdir()
    program = FakeProgram(tmp_path / "bin", "arduino-cli", monkeypatch)
    built = replace(await build(tmp_path, "uno"), board=find_board("esp32:esp32:esp32"))
    await upload(built, "/dev/ttyUSB0")
    folder = str(built.image.parent)
    assert program.calls == [
        ["upload", "--fqbn", "esp32:esp32:esp32", "--port", "/dev/ttyUSB0", "--input-dir", folder]
    ]
