"""The names of this machine, to check the `Host` of HTTP requests.

A web page may let its own name resolve to our address (DNS rebinding). The browser then treats our server as
the page's own, but the `Host` of its requests is still the page's name. An address as `Host` is always safe.
"""

from __future__ import annotations

import contextlib
import ipaddress
import socket
from collections.abc import Iterable
from functools import cache
from pathlib import Path

_HOSTS = Path("/etc/hosts")
_RESOLVER = Path("/etc/resolv.conf")


class OwnNames:
    """This machine's names and `names` given by the user."""

    def __init__(self, names: Iterable[str] = ()) -> None:
        self._names = {_plain(name) for name in names if name}

    def include(self, host: str) -> bool:
        """Return whether a Host header (`name`, `name:port`, `[::1]:port`, an address) means this machine."""
        name = host.strip()
        if name.count(":") == 1 or "]:" in name:
            name = name.rpartition(":")[0]
        name = _plain(name)
        return (
            is_address(name)
            or name == "localhost"
            or name.endswith(".localhost")
            or name in self._names
            or name in _machine_names()
        )


def is_address(host: str) -> bool:
    """Return whether a host is an IP address; an IPv6 one may be in brackets."""
    try:
        ipaddress.ip_address(host[1:-1] if host.startswith("[") and host.endswith("]") else host)
    except ValueError:
        return False
    return True


def outward_address(family: socket.AddressFamily = socket.AF_INET) -> str | None:
    """Return the address at which other machines reach this one, None without a network."""
    target = "2001:db8::1" if family == socket.AF_INET6 else "192.0.2.1"
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            # This sends nothing, and only asks the system for the route.
            probe.connect((target, 9))
            return str(probe.getsockname()[0])
    except OSError:
        return None


def own_addresses() -> set[ipaddress.IPv4Address | ipaddress.IPv6Address]:
    """Return the addresses of this machine, from its routes and its name; may ask a resolver."""
    found = ["127.0.0.1", "::1"]
    found += [each for each in (outward_address(), outward_address(socket.AF_INET6)) if each]
    # The name of this machine may have no address.
    with contextlib.suppress(OSError):
        found += [str(entry[4][0]) for entry in socket.getaddrinfo(socket.gethostname(), None)]
    return {ipaddress.ip_address(each.partition("%")[0]) for each in found}


def is_own_address(host: str, scope: int = 0) -> bool:
    """Return whether a numeric address belongs to this machine: datagrams to it are then sent from it.

    `scope` is the interface index of a link-local IPv6 address. 0.0.0.0 is included: if no
    other interface than `lo` has an address, Linux sends from 0.0.0.0 to a group.
    """
    is_ipv6 = ":" in host
    try:
        with socket.socket(socket.AF_INET6 if is_ipv6 else socket.AF_INET, socket.SOCK_DGRAM) as probe:
            # This sends nothing. A test with `bind` would be wrong where ip_nonlocal_bind is set.
            probe.connect((host, 9, 0, scope) if is_ipv6 else (host, 9))
            return bool(probe.getsockname()[0] == probe.getpeername()[0])
    except OSError:
        return False


def _plain(name: str) -> str:
    return name.lower().rstrip(".")


@cache
def _machine_names() -> frozenset[str]:
    """Return the machine's names from its own files; a resolver may be slow or untrusted."""
    own = _plain(socket.gethostname())
    label = own.partition(".")[0]
    names = {own, label, f"{label}.local"}
    for fields in _fields(_RESOLVER):
        if fields[0] in ("search", "domain"):
            names.update(f"{label}.{_plain(domain)}" for domain in fields[1:])
    for fields in _fields(_HOSTS):
        aliases = {_plain(alias) for alias in fields[1:]}
        if aliases & names or (is_address(fields[0]) and ipaddress.ip_address(fields[0]).is_loopback):
            names |= aliases
    return frozenset(names)


def _fields(path: Path) -> list[list[str]]:
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
    return [fields for line in lines[:10_000] if (fields := line.partition("#")[0].split())]
