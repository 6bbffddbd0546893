from __future__ import annotations

import pytest

from rostether.bridge.identity import hardware_id, identify_peer, node_base_name, node_name, numbered
from rostether.names.graph_name import is_legal_name
from rostether.ports.board_identity import BoardIdentity
from rostether.ports.settings import DeviceSettings
from rostether.transports.address_parser import parse_address


@pytest.mark.parametrize(
    ("address", "peer", "serial_number", "name"),
    [
        ("/dev/ttyACM0?name=arm", "/dev/ttyACM0", "75330303035351F04110", "arm"),
        ("/dev/ttyACM0?name=left/arm", "/dev/ttyACM0", None, "left/arm"),
        ("/dev/ttyACM0", "/dev/ttyACM0", "75330303035351F04110", "board_75330303035351F04110"),
        ("/dev/ttyACM0", "/dev/ttyACM0", None, "ttyACM0"),
        ("/dev/serial/by-id/usb-1a86_USB-if00", "", None, "usb_1a86_USB_if00"),
        ("COM3", "COM3", None, "COM3"),
        ("/dev/1st", "/dev/1st", None, "board_1st"),
        ("pty:/tmp/board", "pty /tmp/board", None, "board"),
        ("tcp://0.0.0.0:11411", "tcp 192.168.1.7:51234", None, "tcp_192_168_1_7"),
        ("tcp://[::]:11411", "tcp [fe80::1%eth0]:51234", None, "tcp_fe80_1_eth0"),
        ("udp://:11411", "udp 127.0.0.1:5000", None, "udp_127_0_0_1"),
        ("tcp://robot.local:11411?connect=yes", "tcp robot.local:11411", None, "tcp_robot_local"),
        ("xbee:/dev/ttyUSB0", "xbee 0x0001", None, "xbee_0x0001"),
    ],
)
def test_name_of_a_board(address: str, peer: str, serial_number: str | None, name: str) -> None:
    remote = peer.partition(" ")[2].rpartition(":")[0].strip("[]") if ":" in peer else None
    identity = BoardIdentity(serial_number=serial_number, address=remote)
    found = node_base_name(parse_address(address), peer, identity)
    assert found == name
    assert is_legal_name(found)


@pytest.mark.parametrize("number_of", ["", "???", "\u00e4\u00f6", "9" * 200, "/", "a" * 200])
def test_any_serial_number_gives_a_legal_name(number_of: str) -> None:
    name = node_base_name(parse_address("/dev/tty0"), "/dev/tty0", BoardIdentity(serial_number=number_of))
    assert name
    assert is_legal_name(name)
    assert "/" not in name
    assert len(name) <= 70


def test_boards_of_one_name_are_numbered() -> None:
    assert [numbered("arm", number) for number in (1, 2, 3)] == ["arm", "arm_2", "arm_3"]


def test_a_file_names_boards_that_the_address_does_not() -> None:
    nobody = BoardIdentity()
    device = DeviceSettings(name="arm", namespace="/lab")
    assert node_name(parse_address("/dev/ttyACM0"), "", nobody, device) == "/lab/arm"
    assert node_name(parse_address("/dev/ttyACM0?name=leg"), "", nobody, device) == "/lab/leg"
    assert node_name(parse_address("/dev/ttyACM0?ns=hall"), "", nobody, device) == "/hall/arm"
    assert node_name(parse_address("/dev/ttyACM0"), "", nobody) == "/ttyACM0"


@pytest.mark.parametrize(
    ("address", "peer", "identity", "lasting"),
    [
        ("tcp://:1", "tcp 192.168.1.7:51234", BoardIdentity(address="192.168.1.7"), "tcp 192.168.1.7"),
        ("udp://:1", "udp [fe80::1]:5", BoardIdentity(address="fe80::1"), "udp fe80::1"),
        ("xbee:/dev/ttyUSB0", "xbee 0x0001", BoardIdentity(), "xbee 0x0001"),
        ("/dev/ttyACM0", "/dev/ttyACM0", BoardIdentity(usb_location="1-2"), "1-2"),
    ],
)
def test_endpoints_stay_when_a_board_reconnects(
    address: str, peer: str, identity: BoardIdentity, lasting: str
) -> None:
    assert hardware_id(parse_address(address), peer, identity) == lasting


def test_a_network_board_is_known_by_its_address() -> None:
    assert identify_peer("192.168.1.7").address == "192.168.1.7"
    assert identify_peer(None).address is None
