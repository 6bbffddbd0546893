"""The slave of a pseudo-terminal replaces the port; fakes replace real ports where they differ."""

from __future__ import annotations

import asyncio
import fcntl
import os
import subprocess
import sys
import termios
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest
import serialx

from rostether.errors import ConfigError, RostetherError, TransportClosedError, TransportOpenError
from rostether.transports import serial, serial_errors
from rostether.transports.address import SerialAddress
from rostether.transports.serial import SerialTransport, list_ports, open_serial
from rostether.transports.serial_errors import explain_open_error, find_holder, is_pseudo_terminal
from rostether.transports.serial_port import SerialPort
from unit.transports.recorder import Recorder
from waiting import until

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


class Board:
    """The far end of the line."""

    def __init__(self) -> None:
        self.fd, slave = os.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        self._slave: int | None = slave
        os.set_blocking(self.fd, False)

    async def read(self, count: int) -> bytes:
        data = bytearray()

        def more() -> bool:
            try:
                data.extend(os.read(self.fd, 65536))
            except BlockingIOError:
                return False
            return len(data) >= count

        await until(more)
        return bytes(data)

    def unplug(self) -> None:
        if self._slave is not None:
            os.close(self._slave)
            self._slave = None
            os.close(self.fd)


@pytest.fixture
def board() -> Iterator[Board]:
    board = Board()
    yield board
    board.unplug()


async def opened(board: Board, *, baud: int = 57600, reset: bool = True) -> tuple[SerialTransport, Recorder]:
    transport, recorder = await open_serial(SerialAddress(board.path, baud, reset)), Recorder()
    transport.start(recorder)
    return transport, recorder


@pytest.mark.parametrize("baud", [57600, 250000, 1234567])
async def test_carry_all_bytes_raw_both_ways(board: Board, baud: int) -> None:
    transport, seen = await opened(board, baud=baud)
    every_byte = bytes(range(256))
    os.write(board.fd, every_byte)
    await seen.until_received(every_byte)
    transport.write(every_byte)
    assert await board.read(256) == every_byte
    assert transport.can_pause
    assert transport.peer == board.path
    transport.close()
    await transport.wait_closed()
    assert seen.losses == [None]


async def test_a_link_to_a_terminal_is_a_terminal(board: Board, tmp_path: Path) -> None:
    link = tmp_path / "board"
    link.symlink_to(board.path)
    assert is_pseudo_terminal(str(link))
    transport = await open_serial(SerialAddress(str(link)))
    assert transport.can_pause
    transport.close()
    await transport.wait_closed()


def test_a_real_port_cannot_pause() -> None:
    for path in ("/dev/ttyUSB0", "/dev/ttyACM0", "/dev/ttyS0", "COM3", "/dev/cu.usbmodem1"):
        assert not is_pseudo_terminal(path)
    for path in ("/dev/pts/7", "/dev/ttys003", "/dev/ttyp0"):
        assert is_pseudo_terminal(path)


async def test_unplugging_ends_the_transport(board: Board) -> None:
    transport, seen = await opened(board)
    board.unplug()
    error = await seen.until_lost()
    assert isinstance(error, TransportClosedError)
    assert f"{board.path} is gone" in str(error)
    transport.write(b"into the void")
    transport.close()
    await transport.wait_closed()
    assert seen.losses == [error]


async def test_writing_to_a_port_just_unplugged_does_not_raise(board: Board) -> None:
    transport, seen = await opened(board)
    board.unplug()
    for _ in range(3):
        transport.write(b"x")
    assert isinstance(await seen.until_lost(), TransportClosedError)


async def test_a_port_opens_once_and_the_error_names_its_holder(board: Board) -> None:
    transport, _ = await opened(board)
    with pytest.raises(TransportOpenError, match=f"{board.path} is in use by this program; close"):
        await open_serial(SerialAddress(board.path))
    transport.close()
    await transport.wait_closed()
    again = await open_serial(SerialAddress(board.path))
    again.close()
    await again.wait_closed()


async def test_another_program_that_has_the_port_is_named(board: Board) -> None:
    hold = """
import fcntl, os, sys
fcntl.flock(os.open(sys.argv[1], os.O_RDWR), fcntl.LOCK_EX)
print(flush=True)
input()
"""
    with subprocess.Popen(
        [sys.executable, "-c", hold, board.path], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout is not None
        other.stdout.readline()
        with pytest.raises(TransportOpenError, match=rf"in use by python.* \(PID {other.pid}\); close"):
            await open_serial(SerialAddress(board.path))
        other.communicate(b"\n")


def test_a_port_that_is_not_open_has_no_holder(tmp_path: Path) -> None:
    assert find_holder(str(tmp_path / "nobody")) is None


async def test_pausing_blocks_the_board_and_loses_nothing(board: Board) -> None:
    transport, seen = await opened(board)
    transport.pause_reading()
    sent = bytearray()
    with pytest.raises(BlockingIOError):
        while True:
            chunk = os.urandom(1000)
            sent += chunk[: os.write(board.fd, chunk)]
    transport.resume_reading()
    await seen.until_received(bytes(sent))
    transport.close()
    await transport.wait_closed()


async def test_close_flushes_data_to_a_board_that_reads(board: Board) -> None:
    transport, seen = await opened(board)
    data = os.urandom(200_000)
    transport.write(data)
    assert transport.write_buffer_bytes > 0
    assert seen.write_pauses == [True]
    transport.close()
    transport.write(b"too late")
    assert await board.read(len(data)) == data
    assert await seen.until_lost() is None


async def test_close_drops_data_for_a_board_that_does_not_read(board: Board) -> None:
    transport, seen = await opened(board)
    transport.write(bytes(200_000))
    loop = asyncio.get_running_loop()
    began_s = loop.time()
    transport.close()
    assert await seen.until_lost() is None
    assert loop.time() - began_s < 30


@pytest.mark.parametrize(("reset", "hangs_up"), [(True, True), (False, False)])
async def test_without_reset_the_lines_do_not_change_at_close(
    board: Board, reset: bool, hangs_up: bool
) -> None:
    transport, _ = await opened(board, reset=reset)
    assert transport._wire is not None
    fd = os.open(board.path, os.O_RDWR | os.O_NOCTTY)
    assert bool(termios.tcgetattr(fd)[2] & termios.HUPCL) is hangs_up
    os.close(fd)
    transport.close()
    await transport.wait_closed()


@pytest.mark.parametrize("reset", [True, False])
async def test_reset_decides_whether_dtr_and_rts_are_touched(
    board: Board, monkeypatch: pytest.MonkeyPatch, reset: bool
) -> None:
    asked: dict[str, object] = {}
    connect = serialx.create_serial_connection

    async def spy(*args: object, **options: object) -> object:
        asked.update(options)
        return await connect(*args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(serialx, "create_serial_connection", spy)
    transport = await open_serial(SerialAddress(board.path, reset=reset))
    transport.close()
    await transport.wait_closed()
    pins = [asked[f"{pin}_on_{moment}"] for moment in ("open", "close") for pin in ("dtr", "rts")]
    high, low, none = serialx.PinState.HIGH, serialx.PinState.LOW, serialx.PinState.UNDEFINED
    assert pins == ([high, high, low, low] if reset else [none] * 4)


async def test_a_missing_port_is_reported_with_what_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    missing = SerialAddress(str(tmp_path / "ttyACM0"))
    monkeypatch.setattr(serial, "list_ports", list)
    with pytest.raises(TransportOpenError, match=r"no serial port .*ttyACM0; no serial port found"):
        await open_serial(missing)
    ports = [SerialPort(f"/dev/ttyUSB{number}", "CH340") for number in range(8)]
    monkeypatch.setattr(serial, "list_ports", lambda: ports)
    with pytest.raises(TransportOpenError, match=r"choose from: /dev/ttyUSB0 \(CH340\), .* and 2 more"):
        await open_serial(missing)


async def test_a_file_is_not_a_serial_port(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("x")
    # The random numbers refuse every speed, as a port refuses an unknown one.
    for place in (path, tmp_path, Path("/dev/urandom")):
        with pytest.raises(TransportOpenError, match="is not a serial port"):
            await open_serial(SerialAddress(str(place)))


def explained(error: Exception, *, baud: int = 57600, path: str = "/dev/tty_not_there") -> RostetherError:
    return explain_open_error(SerialAddress(path, baud), error, list)


def test_no_permission_names_the_group_and_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    error = PermissionError(13, "Permission denied")
    assert "sudo usermod -aG dialout $USER" in str(explained(error))
    import grp

    port = tmp_path / "ttyACM0"
    port.touch()
    port.chmod(0o660)
    monkeypatch.setattr(grp, "getgrgid", lambda _gid: grp.struct_group(("uucp", "x", 14, [])))
    assert "group uucp, and you are not in it; run: sudo usermod -aG uucp $USER" in str(
        explained(error, path=str(port))
    )
    port.chmod(0o600)
    assert "sudo chmod a+rw" in str(explained(error, path=str(port)))
    port.chmod(0o660)
    monkeypatch.setattr(grp, "getgrgid", lambda _gid: grp.struct_group(("root", "x", 0, [])))
    assert "sudo chmod a+rw" in str(explained(error, path=str(port)))


def test_windows_reports_access_denied_for_a_busy_port(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serial_errors.sys, "platform", "win32")  # type: ignore[attr-defined]
    assert "is in use by another program" in str(explained(PermissionError(13, "Access is denied")))


@pytest.mark.parametrize(
    ("error", "kind", "reported"),
    [
        (OSError(16, "Device or resource busy"), TransportOpenError, "is in use by another program"),
        (OSError(6, "No such device or address"), TransportOpenError, "no device answers on"),
        (OSError(5, "Input/output error"), TransportOpenError, "no device answers on"),
        (OSError(24, "Too many open files"), TransportOpenError, "Too many open files"),
        (OSError(22, "Invalid argument"), ConfigError, "does not support 3 baud"),
        (ValueError("Unsupported baudrate 3"), ConfigError, "choose another with"),
    ],
)
def test_every_other_failure_in_one_line(error: Exception, kind: type[RostetherError], reported: str) -> None:
    explanation = explained(error, baud=3)
    assert type(explanation) is kind
    assert reported in str(explanation)
    assert "\n" not in str(explanation)


def test_list_ports_with_what_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    uno = serialx.SerialPortInfo(
        device="/dev/serial/by-id/usb-Arduino_Uno_7583-if00",
        resolved_device="/dev/ttyACM0",
        vid=0x2341,
        pid=0x0043,
        serial_number="7583",
        manufacturer="Arduino",
        product="Uno",
        bcd_device=1,
        interface_description=None,
        interface_num=0,
    )
    plain = serialx.SerialPortInfo("/dev/ttyS0", "/dev/ttyS0", *[None] * 8)
    named = serialx.SerialPortInfo(
        "/dev/ttyUSB0", "/dev/ttyUSB0", 1, 2, None, "FTDI", "FTDI Cable", 0, "Port A", 0
    )
    monkeypatch.setattr(serialx, "list_serial_ports", lambda: [named, plain, uno])
    assert list_ports() == [
        SerialPort(
            "/dev/ttyACM0",
            "Arduino Uno",
            "/dev/serial/by-id/usb-Arduino_Uno_7583-if00",
            0x2341,
            0x0043,
            "7583",
            "Arduino",
            usb_interface=0,
        ),
        SerialPort("/dev/ttyS0", "serial port"),
        SerialPort("/dev/ttyUSB0", "FTDI Cable (Port A)", None, 1, 2, None, "FTDI", usb_interface=0),
    ]


def test_the_real_ports_can_be_listed() -> None:
    assert all(port.path and port.description for port in list_ports())


async def test_an_open_port_is_locked_for_others(board: Board) -> None:
    transport, _ = await opened(board)
    fd = os.open(board.path, os.O_RDWR | os.O_NOCTTY)
    with pytest.raises(BlockingIOError):
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    os.close(fd)
    transport.close()
    await transport.wait_closed()


async def test_the_speed_of_an_open_port_is_changed(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    transport, _ = await opened(board)
    assert not transport.has_baud
    assert transport.set_baud(115200)
    transport.close()
    await transport.wait_closed()
    # The kernel accepts any speed for a pseudo-terminal, although it has none.
    monkeypatch.setattr(serial, "is_pseudo_terminal", lambda path: False)
    port = await open_serial(SerialAddress(board.path, 57600))
    assert port.has_baud
    for baud, constant in ((115200, termios.B115200), (9600, termios.B9600)):
        assert port.set_baud(baud)
        fd = os.open(board.path, os.O_RDWR | os.O_NOCTTY)
        assert termios.tcgetattr(fd)[4:6] == [constant, constant]
        os.close(fd)
    assert port.set_baud(250000)

    def refuse(*, baudrate: int) -> None:
        raise serialx.UnsupportedSetting(f"Unsupported baudrate {baudrate}")

    with monkeypatch.context() as refused:
        refused.setattr(
            serialx.Serial, "reconfigure_port", lambda _port, *, baudrate: refuse(baudrate=baudrate)
        )
        assert not port.set_baud(3)
    port.close()
    await port.wait_closed()
    assert port.set_baud(9600)


async def test_a_port_changes_its_receiver_and_loses_nothing(board: Board) -> None:
    transport, first = await opened(board)
    os.write(board.fd, b"one ")
    await first.until_received(b"one ")
    transport.pause_reading()
    os.write(board.fd, b"two ")
    transport.release(b"unread ")
    second = Recorder()
    transport.start(second)
    os.write(board.fd, b"three")
    await second.until_received(b"unread two three")
    assert bytes(first.data) == b"one "
    transport.close()
    await transport.wait_closed()
