"""Tethers microcontrollers to ROS: serial boards become nodes of a ROS graph, with no ROS installed."""

from __future__ import annotations

TYPE_CHECKING = False  # without typing, which would be most of what the command's first moments take

if TYPE_CHECKING:
    from rostether.device import Device
    from rostether.joining import join

__all__ = ["Device", "join"]

# Imported when first asked for: the command line starts without them.
_HOMES = {"Device": "rostether.device", "join": "rostether.joining"}


def __getattr__(name: str) -> object:
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value = globals()[name] = getattr(import_module(home), name)
    return value
