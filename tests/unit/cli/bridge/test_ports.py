from __future__ import annotations

from pathlib import Path

import pytest

from rostether.transports.serial_port import SerialPort
from unit.cli.command_shell import Shell


@pytest.fixture
def plugged(monkeypatch: pytest.MonkeyPatch) -> list[SerialPort]:
    """The ports that are found; tests add to them."""
    ports: list[SerialPort] = []
    monkeypatch.setattr("rostether.transports.serial.list_ports", lambda: ports)
    return ports


def test_each_port_has_a_description(plugged: list[SerialPort], shell: Shell, tmp_path: Path) -> None:
    path = tmp_path / "ttyUSB0"
    path.touch()
    by_id = "/dev/serial/by-id/usb-1a86_USB_Serial-if00-port0"
    plugged.append(SerialPort(str(path), "USB Serial", by_id, 0x1A86, 0x7523))
    plugged.append(SerialPort(str(path), "serial port"))
    assert shell.output("ports") == (
        f"{path}  CH340 adapter (Arduino compatible and ESP boards) (USB Serial)  [1a86:7523]\n  {by_id}\n"
        f"{path}  serial port\n"
    )


def test_for_scripts(plugged: list[SerialPort], shell: Shell, tmp_path: Path) -> None:
    path = tmp_path / "ttyACM0"
    path.touch()
    port = SerialPort(
        str(path), "Arduino Uno", "/dev/serial/by-id/x", 0x2341, 0x43, "75833", "Arduino", "1-2:1.0"
    )
    plugged.append(port)
    assert shell("ports", "--json").records == [
        {
            "path": str(path),
            "by_id": "/dev/serial/by-id/x",
            "description": "Arduino Uno",
            "board": "Arduino Uno",
            "manufacturer": "Arduino",
            "usb_id": "2341:0043",
            "serial_number": "75833",
            "usb_location": "1-2:1.0",
            "is_accessible": True,
        }
    ]
    assert f"{path}  Arduino Uno  [2341:0043]\n" in shell.output("ports")


def test_no_port_at_all_gives_a_hint(plugged: list[SerialPort], shell: Shell) -> None:
    result = shell("ports")
    assert (result.code, result.out) == (0, "")
    assert "a USB cable that carries data" in result.err
    assert shell("ports", "--json").out == ""


def test_a_port_that_may_not_be_used_names_the_group(
    plugged: list[SerialPort], shell: Shell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "ttyACM0"
    path.touch(0o660)
    plugged.append(SerialPort(str(path), "serial port"))
    # Root has all permissions, so they cannot be tested.
    monkeypatch.setattr("os.access", lambda path, mode: False)
    result = shell("ports")
    assert result.out == f"{path}  serial port  no permission\n"
    assert result.err.startswith(f"no permission to open {path}")
    assert "sudo " in result.err
    assert shell("ports", "--json").records[0]["is_accessible"] is False
