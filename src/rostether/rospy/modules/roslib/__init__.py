"""roslib: the functions from before catkin, and those that convert type names to classes."""

# ruff: noqa: F401
from . import message, names, packages


def load_manifest(package_name: str) -> None:
    """Do nothing: packages are importable as they are."""


def is_interactive() -> bool:
    """Return False: there is no interactive session."""
    return False
