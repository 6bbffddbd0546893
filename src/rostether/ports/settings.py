"""The user's settings for a board and for discovery; `devices_toml` reads them from a file."""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase
from types import MappingProxyType
from typing import Any

from msgspec import Struct

from rostether.errors import AccessDeniedError

# The verbs that differ from their field.
_VERBS = {"subscribe": "subscribe to", "parameters": "read"}


class NameRule(Struct, frozen=True):
    """Which resolved names are permitted: those in `allow` (None: all) that are not in `deny`.

    Entries are global names in which `*` matches any characters, including slashes.
    """

    allow: tuple[str, ...] | None = None
    deny: tuple[str, ...] = ()

    def refusal(self, name: str) -> str | None:
        """Return the reason why a resolved name is refused, None if it is permitted."""
        for pattern in self.deny:
            if fnmatchcase(name, pattern):
                return f'deny has "{pattern}"'
        if self.allow is None or any(fnmatchcase(name, pattern) for pattern in self.allow):
            return None
        return "allow has no entry for it"


ANY_NAME = NameRule()


class Access(Struct, frozen=True):
    """The access rights of a board on the graph; directions are the board's.

    `publish`, `subscribe`: topics. `serve`: services it offers. `call`: services it calls. `parameters`:
    parameters it may request.
    """

    publish: NameRule = ANY_NAME
    subscribe: NameRule = ANY_NAME
    serve: NameRule = ANY_NAME
    call: NameRule = ANY_NAME
    parameters: NameRule = ANY_NAME

    def check(self, kind: str, name: str) -> None:
        """Check that the board may use a resolved name; `kind` is a field. Raises AccessDeniedError."""
        rule: NameRule = getattr(self, kind)
        if (reason := rule.refusal(name)) is not None:
            raise AccessDeniedError(
                f"this board may not {_VERBS.get(kind, kind)} {name}: access.{kind}.{reason}; change "
                "devices.toml to allow it"
            )


ANY_ACCESS = Access()


class DeviceMatch(Struct, frozen=True, kw_only=True):
    """How a board is recognized: all given keys must match.

    `serial_number` and `usb_id` (`2341:0043`) are the USB device's, `usb_location` is its USB socket
    (`1-1.2:1.0`), `port` a port's path, link or pattern (`/dev/ttyUSB*`), `address` a network
    address, `psk` and `certificate` the files of its key and certificate.
    """

    serial_number: str | None = None
    usb_id: str | None = None
    usb_location: str | None = None
    port: str | None = None
    address: str | None = None
    psk: str | None = None
    certificate: str | None = None


class DeviceSettings(Struct, frozen=True, kw_only=True):
    """One board's settings; None or empty means the default.

    `name` is its node name, `namespace` the namespace of its relative names. `baud` skips the detection of
    the baud rate. `reset=False` does not change DTR. `remap` maps its names to others, like `a:=b`.
    `required_topics` are reported if it does not announce them. `queue_depths` limits the waiting messages of
    a topic. `grace_s` is the time that its node stays in the graph after it is lost. `limits` overrides
    limits of the bridge for this board, see `devices_toml.BOARD_LIMITS`.
    """

    name: str | None = None
    match: DeviceMatch | None = None
    baud: int | None = None
    reset: bool | None = None
    namespace: str | None = None
    remap: Mapping[str, str] = MappingProxyType({})
    required_topics: tuple[str, ...] = ()
    access: Access = ANY_ACCESS
    queue_depths: Mapping[str, int] = MappingProxyType({})
    grace_s: float | None = None
    limits: Mapping[str, Any] = MappingProxyType({})


NO_SETTINGS = DeviceSettings()


class DiscoverySettings(Struct, frozen=True, kw_only=True):
    """The ports for automatic discovery: known boards and `probe`, but not `ignore`.

    Entries are USB ids (`1a86:7523`), paths or patterns (`/dev/ttyUSB*`), or `all`.
    """

    probe: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
