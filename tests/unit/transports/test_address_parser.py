from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.transports.address import (
    Address,
    PtyAddress,
    SerialAddress,
    TcpAddress,
    UdpAddress,
    WebAddress,
    XbeeAddress,
)
from rostether.transports.address_parser import parse_address


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("/dev/ttyACM0", SerialAddress("/dev/ttyACM0", 57600)),
        ("/dev/ttyACM0?baud=115200", SerialAddress("/dev/ttyACM0", 115200)),
        ("COM3", SerialAddress("COM3")),
        ("com12?baud=9600", SerialAddress("com12", 9600)),
        ("\\\\.\\COM10", SerialAddress("\\\\.\\COM10")),
        ("./board", SerialAddress("./board")),
        ("serial:COM3", SerialAddress("COM3")),
        ("serial:/dev/ttyUSB0?baud=57600&reset=no", SerialAddress("/dev/ttyUSB0", 57600, reset=False)),
        ("serial:///dev/ttyUSB0", SerialAddress("/dev/ttyUSB0")),
        ("/dev/ttyACM0?name=arm&ns=left", SerialAddress("/dev/ttyACM0", name="arm", ns="left")),
        ("tcp://:11411", TcpAddress("127.0.0.1", 11411)),
        ("tcp:", TcpAddress("127.0.0.1", 11411)),
        ("tcp://0.0.0.0:0", TcpAddress("0.0.0.0", 0)),
        ("TCP://robot.local", TcpAddress("robot.local", 11411)),
        ("tcp://[::1]:5?connect=yes", TcpAddress("::1", 5, connect=True)),
        ("tcp://[::]", TcpAddress("::", 11411)),
        (
            "tcp://0.0.0.0:1?allow=10.0.0.0/8,192.168.1.7",
            TcpAddress("0.0.0.0", 1, allow=("10.0.0.0/8", "192.168.1.7")),
        ),
        ("udp://:11411", UdpAddress("127.0.0.1", 11411)),
        ("udp://b:7?connect=on&bind=8", UdpAddress("b", 7, connect=True, bind=8)),
        ("pty:/tmp/board", PtyAddress("/tmp/board")),
        ("pty:board?name=b", PtyAddress("board", name="b")),
        ("web:?ns=lab", WebAddress(ns="lab")),
        ("xbee:/dev/ttyUSB0?baud=57600&peers=1,0x2a", XbeeAddress("/dev/ttyUSB0", 57600, (1, 42))),
        ("xbee:/dev/x?peers=0013A20040A1B2C3", XbeeAddress("/dev/x", peers=(0x0013A20040A1B2C3,))),
    ],
)
def test_read_as_typed(text: str, address: Address) -> None:
    assert parse_address(text) == address


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ("", "empty link address"),
        ("?baud=1", "empty link address"),
        ("ttyACM0", "/dev/ttyACM0"),
        (
            "/dev/x?speed=9600",
            "unknown option 'speed' in link address '/dev/x?speed=9600'; known: baud, reset",
        ),
        ("xbee: ?peers=2", "has no path"),
        ("/dev/tty\n0", "has invisible characters"),
        ("tcp://:1?baud=9600", "known: connect, allow, psk, name, ns"),
        ("pty:/x?baud=9600", "known: name, ns"),
        ("/dev/x?baud=fast", "write a number from 1"),
        ("/dev/x?baud=-1", "write a number from 1"),
        ("/dev/x?baud=0", "write a number from 1"),
        ("/dev/x?baud=99999999999", "write a number from 1"),
        (f"/dev/x?baud={'9' * 5000}", "write a number from 1"),
        (f"tcp://host:{'9' * 5000}", "is not a port"),
        ("/dev/x?baud", "has no value; write baud=VALUE"),
        ("/dev/x?baud=", "has no value; write baud=VALUE"),
        ("/dev/x?baud=1&baud=2", "is given twice"),
        ("/dev/x?&", "unknown option ''"),
        ("/dev/x?reset=maybe", "write reset=yes or reset=no"),
        ("tcp://:port", "is not a port"),
        ("tcp://:65536", "is not a port"),
        ("tcp://:²", "is not a port"),
        ("tcp://[::1", "malformed IPv6"),
        ("tcp://[::1]x", "malformed IPv6"),
        ("tcp://a/b:1", "is not a host name"),
        ("tcp://a b:1", "is not a host name"),
        ("tcp://:1?allow=everybody", "'everybody' is not a network"),
        ("udp://h?connect=yes&bind=70000", "write a number from 0 to 65535"),
        ("pty:", "has no path"),
        ("tcp:11411", "has no host; write tcp://:11411 to listen on that port"),
        ("serial:", "has no path"),
        ("xbee:/dev/x?peers=one", "with its 16-bit address or the address on its label"),
        ("xbee:/dev/x?peers=0xffff", "with its 16-bit address or the address on its label"),
        ("bluetooth:/dev/x", "unknown kind of link 'bluetooth'"),
    ],
)
def test_refuse_with_what_to_type(text: str, reported: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_address(text)
    assert reported in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "listens"),
    [
        ("/dev/x", False),
        ("pty:/x", False),
        ("tcp://:1", True),
        ("tcp://:1?connect=yes", False),
        ("udp://:1", True),
        ("udp://:1?connect=yes", False),
        ("xbee:/dev/x", True),
    ],
)
def test_reports_whether_many_devices_connect(text: str, listens: bool) -> None:
    assert parse_address(text).listens is listens


@pytest.mark.parametrize(
    "text", ["/dev/ttyACM0", "tcp://127.0.0.1:11411", "udp://[::1]:2", "pty:/tmp/b", "xbee:/x"]
)
def test_show_what_was_typed_without_options(text: str) -> None:
    assert str(parse_address(text)) == text
    assert str(parse_address(f"{text}?name=board")) == text
