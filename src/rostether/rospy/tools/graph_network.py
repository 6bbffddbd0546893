"""rosgraph.network: the name and the address of this machine."""

from __future__ import annotations

import os
import socket
import sys
from urllib.parse import urlsplit

from rostether.transports.own_names import outward_address


def get_address_override() -> str | None:
    """Return the value of `__hostname:=`, `__ip:=`, ROS_HOSTNAME or ROS_IP, or None."""
    for argument in sys.argv:
        name, separator, value = argument.partition(":=")
        if separator and name in ("__hostname", "__ip"):
            return value
    return os.environ.get("ROS_HOSTNAME") or os.environ.get("ROS_IP") or None


def get_host_name() -> str:
    """Return the host name in this machine's URIs."""
    if override := get_address_override():
        return override
    name = socket.gethostname()
    return get_local_address() if not name or name == "localhost" or name.startswith("127.") else name


def get_local_address() -> str:
    """Return this machine's address; loopback if it has no other."""
    if override := get_address_override():
        return override
    return outward_address() or "127.0.0.1"


def parse_http_host_and_port(url: str) -> tuple[str, int]:
    """Return the host and port (default 80) of a URL. Raises ValueError."""
    parts = urlsplit(url or "")
    if not parts.scheme or not parts.hostname:
        raise ValueError("not a valid URL")
    return parts.hostname, parts.port or 80
