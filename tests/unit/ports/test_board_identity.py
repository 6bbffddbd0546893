from __future__ import annotations

import pytest

from rostether.ports.board_identity import BoardIdentity


def test_a_serial_number_identifies_a_board_in_every_socket() -> None:
    here = BoardIdentity(usb_id="2341:0043", serial_number="75", usb_location="1-1:1.0", port="/dev/ttyACM0")
    there = BoardIdentity(usb_id="2341:0043", serial_number="75", usb_location="1-4:1.0", port="/dev/ttyACM1")
    assert here.key == there.key


def test_two_ports_of_one_device_differ() -> None:
    first = BoardIdentity(usb_id="1d50:6018", serial_number="75", usb_interface=0)
    second = BoardIdentity(usb_id="1d50:6018", serial_number="75", usb_interface=2)
    assert first.key != second.key


@pytest.mark.parametrize("number", ["0001", "0000", "", None, "123456"])
def test_a_serial_number_of_all_boards_of_a_kind_is_ignored(number: str | None) -> None:
    identity = BoardIdentity(
        usb_id="10c4:ea60", serial_number=number, usb_location="1-1:1.0", port="/dev/ttyUSB0"
    )
    assert identity.own_serial_number is None
    assert identity.key == "socket 1-1:1.0 10c4:ea60"


def test_without_other_properties_the_port_or_address_identifies_a_board() -> None:
    assert BoardIdentity(port="/dev/ttyS0").key == "port /dev/ttyS0"
    assert BoardIdentity(address="10.0.0.7").key == "net 10.0.0.7"
