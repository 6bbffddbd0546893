from __future__ import annotations

import re
from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.transports.address_advice import check_typed_port
from rostether.transports.address_parser import parse_address
from rostether.transports.serial_port import SerialPort

PORTS = [SerialPort("/dev/ttyS0", "a port"), SerialPort("/dev/ttyACM7", "an Uno")]


def _refused(address: str) -> str:
    with pytest.raises(ConfigError) as caught:
        check_typed_port(parse_address(address), lambda: PORTS)
    return str(caught.value)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("/dev/ttyACMO", "/dev/ttyACM0 (with a zero)"),
        ("/dev/ttyUSBo?baud=115200", "/dev/ttyUSB0 (with a zero)"),
        ("/dev/ttyUSBl", "/dev/ttyUSB1"),
        ("/dev/ttyACM", "/dev/ttyACM0"),
        ("/dev/ttyusb98", "/dev/ttyUSB98"),
        ("/dev/ACM98", "/dev/ttyACM98"),
        ("dev/ttyACM98", "/dev/ttyACM98"),
        ("xbee:/dev/ttyUSBO", "/dev/ttyUSB0 (with a zero)"),
        ("/dev/ttyACM98:115200", "/dev/ttyACM98?baud=115200"),
    ],
)
def test_the_meant_port_is_reported(typed: str, meant: str) -> None:
    assert _refused(typed).endswith(f"; did you mean {meant}?")


def test_files_folders_and_names_of_windows_are_not_ports(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert f"{tmp_path}/file is a file, not a serial port; write /dev/ttyACM7" in _refused(f"{tmp_path}/file")
    assert f"{tmp_path} is a folder, not a serial port" in _refused(str(tmp_path))
    (tmp_path / "blink.ino").touch()
    assert f"{tmp_path} is a sketch, not a serial port; write sim:{tmp_path}" in _refused(str(tmp_path))
    cyrillic = "/dev/ttyACM\N{CYRILLIC SMALL LETTER O}"
    assert "is CYRILLIC SMALL LETTER O; type it again" in _refused(cyrillic)
    assert _refused("COM3") == "COM3 is a port's name on Windows; here it is /dev/ttyACM7"


@pytest.mark.parametrize(
    "address",
    [
        "/dev/ttyACM98",
        "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0",
        "/dev/ttyO9",
        "/dev/serial/by-id/x",
        "/no/where",
        "/dev/null",
        "tcp://:0",
    ],
)
def test_what_may_be_plugged_in_later_is_waited_for(address: str) -> None:
    check_typed_port(parse_address(address), lambda: PORTS)


def test_a_number_is_a_tcp_port() -> None:
    with pytest.raises(ConfigError, match=re.escape("to listen on that TCP port, write tcp://:11411")):
        parse_address("11411?name=x")
    with pytest.raises(ConfigError, match=re.escape("not a link address: 'ttyACM0'; ")):
        parse_address("ttyACM0?name=x")
    with pytest.raises(ConfigError, match=re.escape("write it after the port: /dev/ttyACM0?baud=115200")):
        parse_address("115200")


@pytest.mark.parametrize(
    ("typed", "advice"),
    [
        ("COM3:9600", "write COM3?baud=9600"),
        ("ttyACM0:115200", "write /dev/ttyACM0?baud=115200"),
        ("localhost:11411", "write tcp://localhost:11411?connect=yes to connect there"),
        ("blink.ino", "write sim:blink.ino for a simulated board"),
        ("my blink.ino", "`rostether flash 'my blink.ino'` flashes"),
        ("uno", "such as /dev/ttyACM0 (`rostether ports` lists them)"),
    ],
)
def test_what_is_not_an_address_is_explained(typed: str, advice: str) -> None:
    with pytest.raises(ConfigError, match=re.escape(advice)):
        parse_address(typed)


def test_a_host_and_a_kind_of_link_are_explained() -> None:
    with pytest.raises(ConfigError, match=re.escape("tcp://192.168.1.7:PORT?connect=yes")):
        parse_address("192.168.1.7")
    with pytest.raises(ConfigError, match="write udp://:11411 to listen for boards"):
        parse_address("udp")
