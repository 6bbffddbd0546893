"""Connects microcontrollers to ROS: boards become nodes of a ROS graph, without a ROS installation."""

from __future__ import annotations

# Type checkers assume True. Importing it from typing would take most of a command's start-up time.
TYPE_CHECKING = False

if TYPE_CHECKING:
    from rostether import sync
    from rostether.device import Device
    from rostether.joining import join

__all__ = ["Device", "join", "sync"]

# These modules are imported on first use, because the command line starts without them.
_MODULES = {"Device": "rostether.device", "join": "rostether.joining", "sync": "rostether.sync"}


def __getattr__(name: str) -> object:
    module_name = _MODULES.get(name)
    if module_name is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    module = import_module(module_name)
    value = globals()[name] = module if module_name == f"rostether.{name}" else getattr(module, name)
    return value


def __dir__() -> list[str]:
    """Return the public names, including those not imported yet: shells complete them."""
    return list(__all__)
