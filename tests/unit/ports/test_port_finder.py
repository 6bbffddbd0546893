from __future__ import annotations

import os
from pathlib import Path

from rostether.ports.port_finder import PortFinder
from rostether.transports.serial_port import SerialPort


class Desk:
    """Ports as files; the clock stands unless the test turns it."""

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
        # Files made within one tick of the file system's clock would look alike.
        self.now_s += 10
        os.utime(self.folder, (self.now_s, self.now_s))


def test_before_anything_was_seen_the_path_counts(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    assert desk.finder.find() is None
    desk.plug("ttyACM0", "75")
    assert desk.finder.find() == desk.path("ttyACM0")


def test_the_board_is_followed_even_when_another_takes_its_path(tmp_path: Path) -> None:
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


def test_a_port_without_marks_is_identified_by_its_path(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    desk.plug("ttyACM0", None)
    assert desk.finder.identify(desk.path("ttyACM0")).port == desk.path("ttyACM0")
    desk.unplug("ttyACM0")
    desk.plug("ttyACM1", None)
    assert desk.finder.find() is None
    assert desk.finder.identify("/dev/null").key == "port /dev/null"
