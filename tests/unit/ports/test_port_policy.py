from __future__ import annotations

import os
from pathlib import Path

import pytest

from rostether.ports.port_policy import PortFinder, PortUse, identify, port_use
from rostether.ports.settings import NO_SETTINGS, DeviceMatch, DeviceSettings, DiscoverySettings
from rostether.transports.serial_port import SerialPort

UNO = SerialPort("/dev/ttyACM0", "Uno", usb_vendor_id=0x2341, usb_product_id=0x43, serial_number="7")
NANO = SerialPort("/dev/ttyUSB0", "USB Serial", usb_vendor_id=0x1A86, usb_product_id=0x7523)
MODEM = SerialPort("/dev/ttyUSB1", "LTE modem", usb_vendor_id=0x2C7C, usb_product_id=0x125)
GPS = SerialPort("/dev/ttyACM1", "u-blox", usb_vendor_id=0x1546, usb_product_id=0x1A8)
SERVOS = SerialPort("/dev/ttyUSB2", "U2D2", usb_vendor_id=0x403, usb_product_id=0x6014)
BOOTLOADER = SerialPort("/dev/ttyACM2", "Leonardo", usb_vendor_id=0x2341, usb_product_id=0x36)
BUILT_IN = SerialPort("/dev/ttyS0", "serial port")


@pytest.mark.parametrize(
    ("port", "choice"),
    [
        (UNO, PortUse.ASK),
        (NANO, PortUse.LISTEN),
        (MODEM, PortUse.OFFER),
        (GPS, PortUse.OFFER),
        (SERVOS, PortUse.OFFER),
        (BOOTLOADER, PortUse.OFFER),
        (BUILT_IN, PortUse.LEAVE),
    ],
)
def test_without_settings_of_the_user(port: SerialPort, choice: PortUse) -> None:
    assert port_use(port, NO_SETTINGS, DiscoverySettings()) is choice


@pytest.mark.parametrize("entry", ["2c7c:0125", "2C7C:0125", "/dev/ttyUSB1", "/dev/ttyUSB*", "all"])
def test_the_user_allows_a_port(entry: str) -> None:
    assert port_use(MODEM, NO_SETTINGS, DiscoverySettings(probe=(entry,))) is PortUse.EXPECT
    assert port_use(MODEM, NO_SETTINGS, DiscoverySettings(probe=(entry,), ignore=(entry,))) is PortUse.LEAVE


def test_all_means_ports_that_are_not_on_usb_too() -> None:
    assert port_use(BUILT_IN, NO_SETTINGS, DiscoverySettings(probe=("all",))) is PortUse.EXPECT


def test_a_board_in_the_users_file_is_allowed() -> None:
    match = DeviceMatch(usb_id="2c7c:0125")
    assert port_use(MODEM, DeviceSettings(match=match), DiscoverySettings()) is PortUse.EXPECT
    assert port_use(MODEM, DeviceSettings(match=match, baud=9600), DiscoverySettings()) is PortUse.SERVE
    assert port_use(MODEM, DeviceSettings(match=match), DiscoverySettings(ignore=("all",))) is PortUse.EXPECT
    # A baud rate for all boards does not select ports.
    assert port_use(MODEM, DeviceSettings(baud=9600), DiscoverySettings()) is PortUse.OFFER


def test_marks() -> None:
    assert identify(UNO).key == "usb 2341:0043 7"
    assert identify(BUILT_IN).key == "port /dev/ttyS0"


class Desk:
    """Ports as files; only the test advances the clock."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.ports: dict[str, SerialPort] = {}
        self.now_s = 0.0
        self.finder = PortFinder(self.path("ttyACM0"), lambda: list(self.ports.values()), lambda: self.now_s)

    def path(self, name: str) -> str:
        return str(self.folder / name)

    def plug(self, name: str, serial_number: str | None) -> None:
        (self.folder / name).touch()
        self.ports[name] = SerialPort(self.path(name), "Uno", serial_number=serial_number)
        self._changed()

    def unplug(self, name: str) -> None:
        (self.folder / name).unlink()
        del self.ports[name]
        self._changed()

    def _changed(self) -> None:
        # Files that are created within one tick of the file system's clock would be indistinguishable.
        self.now_s += 10
        os.utime(self.folder, (self.now_s, self.now_s))


def test_before_a_board_was_identified_the_path_counts(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    assert desk.finder.find() is None
    desk.plug("ttyACM0", "75")
    assert desk.finder.find() == desk.path("ttyACM0")


def test_the_board_is_found_even_if_another_has_its_path(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    desk.plug("ttyACM0", "75")
    assert desk.finder.identify(desk.path("ttyACM0")).serial_number == "75"
    desk.unplug("ttyACM0")
    assert desk.finder.find() is None
    desk.plug("ttyACM1", "75")
    assert desk.finder.find() == desk.path("ttyACM1")
    desk.plug("ttyACM0", "86")
    assert desk.finder.find() == desk.path("ttyACM1")
    desk.unplug("ttyACM1")
    assert desk.finder.find() == desk.path("ttyACM0")


def test_a_port_without_usb_properties_is_identified_by_its_path(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    desk.plug("ttyACM0", None)
    assert desk.finder.identify(desk.path("ttyACM0")).port == desk.path("ttyACM0")
    desk.unplug("ttyACM0")
    desk.plug("ttyACM1", None)
    assert desk.finder.find() is None
    assert desk.finder.identify("/dev/null").key == "port /dev/null"
