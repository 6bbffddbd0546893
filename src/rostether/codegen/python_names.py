"""The MicroPython names of fields, constants and classes: those of the definition if possible.

A Python keyword or the name of a method gets trailing underscores, as many as make it unique.
"""

from __future__ import annotations

import keyword
from collections.abc import Iterable

from rostether.msgdef.spec import MessageSpec

# `self` is the first argument of a method; the others are members of every message.
_TAKEN = frozenset({"self", "serialize", "deserialize", "_type", "_md5sum"})
# A package of the same name would hide one of these modules of MicroPython or CircuitPython.
MODULES = frozenset(
    """
    array asyncio binascii bluetooth board builtins busio cmath collections cryptolib deflate
    digitalio errno esp esp32 framebuf gc hashlib heapq io json machine math micropython network
    neopixel os platform pwmio random re requests rp2 select socket socketpool ssl struct supervisor
    sys time uasyncio uctypes usb_cdc vfs wifi
    """.split()  # noqa: SIM905 - one word a line would be 50 lines
)


def class_name(short_name: str) -> str:
    """Return the class of a message or service."""
    return f"{short_name}_" if keyword.iskeyword(short_name) else short_name


def package_name(package: str) -> str:
    """Return the Python package of a ROS package, whose name may have dashes."""
    name = package.replace("-", "_")
    return f"{name}_" if keyword.iskeyword(name) else name


def member_names(spec: MessageSpec) -> dict[str, str]:
    """Return the names of the fields and constants of a message by their names in the definition."""
    members = [each.name for each in spec.fields] + [each.name for each in spec.constants]
    names: dict[str, str] = {}
    for each in members:
        names[each] = _first_free(each, members) if keyword.iskeyword(each) or each in _TAKEN else each
    return names


def _first_free(name: str, members: Iterable[str]) -> str:
    taken = set(members)
    candidate = f"{name}_"
    while candidate in taken:
        candidate += "_"
    return candidate
