"""Finds the origin of code: the sketch, a message, the ROS node, a library, the core or the compiler."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from msgspec import Struct

SKETCH = "your sketch"
MESSAGES = "messages"
NODE = "ROS node"
SERIAL = "Serial"
CORE = "Arduino core"
RUNTIME = "C library and arithmetic"
TEXTS = "texts and constants in RAM"
START = "start-up and interrupt table"

_INO = (".ino", ".pde")
_ROS_FOLDERS = ("ros", "tf")
_SERIAL_FILE = re.compile(r"/(HardwareSerial\w*|CDC|USBCore|PluggableUSB|USBAPI|SoftwareSerial)\.(cpp|h)$")
_CORE_FILE = re.compile(r"/(cores|variants)/[^/]+/[^/]+$")
_ROS_FILE = re.compile(r".*/ros_lib/(?:src/)?(?P<rest>.+)$")
_SERIAL_NAME = re.compile(r"\b(HardwareSerial|Serial_|USBDevice_?|Serial\d?)\b")
_MESSAGE_NAME = re.compile(r"\b(\w+_msgs|\w+_srvs|tf|\w+_interfaces)::")


class Origins(Struct, frozen=True):
    """Finds the origin of a file or a name. `libraries` are names with their folders."""

    sketch_folder: Path | None = None
    libraries: Sequence[tuple[str, Path]] = ()

    def of_file(self, file: str) -> str | None:
        """Return the origin of a source file; None for a file of the compiler."""
        path = Path(file)
        if path.suffix in _INO:
            return SKETCH
        is_own = self.sketch_folder is not None and self.sketch_folder in path.parents
        # A sketch may be below a ros_lib, as the library's examples are, and may contain another ros_lib.
        ros = _ROS_FILE.match(str(path).removeprefix(str(self.sketch_folder)) if is_own else file)
        if ros is not None:
            top = ros["rest"].partition("/")[0]
            return NODE if top in _ROS_FOLDERS or "/" not in ros["rest"] else MESSAGES
        for name, folder in self.libraries:
            if folder in path.parents:
                return name
        if is_own:
            return SKETCH
        if _SERIAL_FILE.search(file):
            return SERIAL
        return CORE if _CORE_FILE.search(file) else None

    def of_name(self, name: str) -> str | None:
        """Return the origin of a function, type or table by its readable name, None if unknown."""
        name = name.removeprefix("vtable for ").removeprefix("void ")
        if name.startswith(("ros::", "tf::Transform")):
            return NODE
        if _MESSAGE_NAME.match(name):
            return MESSAGES
        if _SERIAL_NAME.match(name):
            return SERIAL
        scope = name.partition("::")[0].partition("(")[0]
        return next((library for library, _ in self.libraries if library == scope), None)
