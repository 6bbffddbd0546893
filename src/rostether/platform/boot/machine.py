"""Makes the robot.toml of a machine from its role."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Mapping, Sequence
from enum import Enum

from msgspec import Struct, field

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
