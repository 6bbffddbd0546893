"""roslib: the functions from before catkin, and those that convert type names to classes."""

from importlib import import_module as _import_module

for _name in ("message", "names", "packages"):
    _import_module(f"roslib.{_name}")


def load_manifest(package_name: str) -> None:
    """Do nothing: packages are importable without their manifest."""


def is_interactive() -> bool:
    """Return False: there is no interactive session."""
    return False
