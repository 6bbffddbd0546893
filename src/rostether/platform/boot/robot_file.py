"""robot.toml, which lists all programs of one machine of a robot: reads it, and writes a new one."""

from __future__ import annotations

import json
import os
import re
import shlex
from collections.abc import Collection, Mapping, Sequence
from enum import Enum

from msgspec import Struct, field

from rostether.mechanisms.toml_text import parse_toml
from rostether.ports.toml_table import TomlTable

# More programs than a robot's computer runs; each is a process.
MAX_PARTS = 64
# Each line of a part's output begins with its name.
MAX_NAME_CHARACTERS = 64
_VARIABLE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_TOP = ("name", "master", "address", "interface", "environment", "parts")
# The network interface of a robot, for its parts that send to groups.
INTERFACE_VARIABLE = "ROSTETHER_INTERFACE"
_VARIABLES = {
    "PLATFORM_NAME": "name",
    "ROS_MASTER_URI": "master",
    "ROS_IP": "address",
    INTERFACE_VARIABLE: "interface",
}


class Part(Struct, frozen=True):
    """One program of a robot: a name, and the arguments of `rostether`."""

    name: str
    words: tuple[str, ...]


class RobotFile(Struct, frozen=True):
    """The content of a robot.toml."""

    name: str = ""
    environment: Mapping[str, str] = field(default_factory=dict)
    parts: tuple[Part, ...] = ()


def parse_robot_file(text: str, file: str, commands: Collection[str]) -> RobotFile:
    """Return the content of a robot.toml; `file` is its name in errors. Raises ConfigError.

    Each part's first argument must be in `commands`.
    """
    root = TomlTable(file, "", parse_toml(text, file), known=_TOP)
    variables = root.table("environment")
    environment = variables.lines()
    for variable in environment:
        if not _VARIABLE.fullmatch(variable):
            raise variables.error("not the name of a variable, such as ROS_LOG_DIR", variable)
    for variable, key in _VARIABLES.items():
        if (value := root.line(key)) is not None:
            environment[variable] = value
    if not _is_interface(interface := environment.get(INTERFACE_VARIABLE, "")):
        what = "the name of a network interface, such as wlan0"
        raise root.error(f"write {what}, not {interface!r:.80}", "interface")
    table = root.table("parts")
    parts = tuple(_part(table, name, words, commands) for name, words in table.lines().items())
    if not parts:
        raise root.error('no parts; add a table [parts] with a line such as boards = "serve"', "parts")
    if len(parts) > MAX_PARTS:
        raise root.error(f"at most {MAX_PARTS} parts are allowed, not {len(parts)}", "parts")
    return RobotFile(root.line("name") or "", environment, parts)


def _is_interface(name: str) -> bool:
    """Return whether a text is empty, or can be the name of a network interface; an address cannot."""
    # Linux allows 15 bytes.
    is_short = len(os.fsencode(name)) <= 15
    return is_short and re.fullmatch(r"[^\s/,]*", name) is not None and not re.fullmatch(r"[\d.]+", name)


def _part(table: TomlTable, name: str, words: str, commands: Collection[str]) -> Part:
    if not name or len(name) > MAX_NAME_CHARACTERS or not name.isprintable():
        raise table.error(f"a name has 1 to {MAX_NAME_CHARACTERS} printable characters, not {name!r:.80}")
    try:
        split = shlex.split(words)
    except ValueError as error:
        raise table.error(f"must be a command line: {error}", name) from None
    if split[:1] == ["rostether"]:
        split = split[1:]
    if not split or split[0] not in commands:
        raise table.error('must be a rostether command, such as "serve /dev/ttyACM0"', name)
    return Part(name, tuple(split))


# Robots must reach the base station's master, and phones must reach its dashboard.
_REACHABLE = (
    "# With --listen 0.0.0.0, other machines can use the master and the dashboard. To limit this, add",
    "# --allow 192.168.1.0/24 to both, or --token SECRET to the dashboard.",
)


class MachineKind(Enum):
    """The purpose of a machine."""

    BASE = "base"
    ROBOT = "robot"
    BOTH = "both"


class Machine(Struct, frozen=True):
    """The settings for a new robot.toml; `core` is the address of the base station's master.

    Other machines reach this one at `address`, or at the network interface `interface`.
    """

    kind: MachineKind
    name: str
    core: str = ""
    address: str = ""
    interface: str = ""
    boards: Sequence[str] = ()
    parts: Mapping[str, str] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """The content of the robot.toml."""
        lines = [
            "# What this machine runs: each part is a rostether command.",
            f"name = {_quoted(self.name)}",
        ]
        if self.kind is MachineKind.ROBOT:
            lines.append(f"master = {_quoted(_uri(self.core))}")
        if self.address:
            lines.append(f"address = {_quoted(self.address)}")
        if self.interface:
            lines.append(f"interface = {_quoted(self.interface)}")
        lines += ["", *(() if self.kind is MachineKind.ROBOT else _REACHABLE), "[parts]"]
        lines += [f"{_toml_key(name)} = {_quoted(words)}" for name, words in self._all_parts().items()]
        return "\n".join(lines) + "\n"

    def _all_parts(self) -> dict[str, str]:
        parts = {}
        if self.kind is not MachineKind.ROBOT:
            parts["core"] = "core --listen 0.0.0.0"
            parts["sensors"] = "role sensing-manager"
            parts["dashboard"] = "dashboard --no-open --listen 0.0.0.0 --port 8765"
        if self.kind is not MachineKind.BASE:
            parts["boards"] = shlex.join(["serve", *self.boards])
        return parts | dict(self.parts)


def _uri(core: str) -> str:
    if core.startswith("http://"):
        return core
    return f"http://{core}" if ":" in core else f"http://{core}:11311"


def _toml_key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _quoted(name)


def _quoted(text: str) -> str:
    # A JSON string is also a basic string of TOML, if DEL is escaped and no character is a surrogate pair.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")
