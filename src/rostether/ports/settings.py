"""What a user can set for one board, and for the search for boards; `devices_toml` reads it from a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from types import MappingProxyType
from typing import Any

_NOTHING: Mapping[str, str] = MappingProxyType({})
_NO_DEPTHS: Mapping[str, int] = MappingProxyType({})
_NO_LIMITS: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class NameRule:
    """Which resolved names are permitted: those `allow` has (None: all) and `deny` has not.

    Entries are global names in which `*` stands for any characters, slashes too.
    """

    allow: tuple[str, ...] | None = None
    deny: tuple[str, ...] = ()

    def refusal(self, name: str) -> str | None:
        """Return which entry forbids a resolved name, None if it is permitted."""
        for pattern in self.deny:
            if fnmatchcase(name, pattern):
                return f'deny has "{pattern}"'
        if self.allow is None or any(fnmatchcase(name, pattern) for pattern in self.allow):
            return None
        return "allow has no entry for it"


ANY_NAME = NameRule()


@dataclass(frozen=True, slots=True)
class Access:
    """What a board may do in the graph; directions are the board's.

    `publish`, `subscribe`: topics. `serve`: services it offers. `call`: services it calls. `parameters`:
    those it may ask for.
    """

    publish: NameRule = ANY_NAME
    subscribe: NameRule = ANY_NAME
    serve: NameRule = ANY_NAME
    call: NameRule = ANY_NAME
    parameters: NameRule = ANY_NAME


ANY_ACCESS = Access()


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceMatch:
    """How a board is recognised: all that is given must fit.

    `serial_number` and `usb_id` (`2341:0043`) are the USB device's, `usb_location` is the socket it is
    plugged into (`1-1.2:1.0`), `port` a port's path, link or pattern (`/dev/ttyUSB*`), `address` a network
    address, `psk` and `certificate` the files of its own key and certificate.
    """

    serial_number: str | None = None
    usb_id: str | None = None
    usb_location: str | None = None
    port: str | None = None
    address: str | None = None
    psk: str | None = None
    certificate: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceSettings:
    """One board's settings; what is None or empty is as without them.

    `name` is its node name, `namespace` where its relative names resolve. `baud` saves looking for the speed.
    `reset=False` leaves DTR alone. `remap` maps its names to others, as `a:=b` does. `required_topics` are
    reported while it does not announce them. `queue_depths`: how many messages of a topic wait for the board
    at most. `grace_s`: how long its node stays in the graph after it is lost. `limits`: settings of the
    bridge that are others for this board, see `board_limits`.
    """

    name: str | None = None
    match: DeviceMatch | None = None
    baud: int | None = None
    reset: bool | None = None
    namespace: str | None = None
    remap: Mapping[str, str] = field(default_factory=lambda: _NOTHING)
    required_topics: tuple[str, ...] = ()
    access: Access = ANY_ACCESS
    queue_depths: Mapping[str, int] = field(default_factory=lambda: _NO_DEPTHS)
    grace_s: float | None = None
    limits: Mapping[str, Any] = field(default_factory=lambda: _NO_LIMITS)


NO_SETTINGS = DeviceSettings()


@dataclass(frozen=True, slots=True, kw_only=True)
class DiscoverySettings:
    """Which ports are looked at unasked: `probe` besides those known as boards, `ignore` not.

    Entries are USB ids (`1a86:7523`), paths or patterns (`/dev/ttyUSB*`), or `all`.
    """

    probe: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
