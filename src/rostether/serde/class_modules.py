"""Makes a module for each bundled package, whose attributes are looked up when they are first used."""

from __future__ import annotations

import sys
from collections.abc import Callable, MutableMapping
from functools import cache
from types import ModuleType

from rostether.errors import RostetherError
from rostether.msgdef.definition_files import bundled_packages
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore


@cache
def bundled_store() -> TypeStore:
    """Return the store of the bundled types."""
    return TypeStore(Registry())


def add_class_modules(parent: MutableMapping[str, object], find: Callable[[str], object], kind: str) -> None:
    """Add a module for each bundled package to the module with these globals.

    `find` returns the class of `package/Name` or raises a RostetherError; `kind` is its name in errors.
    """
    for package in bundled_packages():
        module = _Package(f"{parent['__name__']}.{package}", find, kind)
        # The import statement finds packages in sys.modules.
        sys.modules[module.__name__] = module
        parent[package] = module


class _Package(ModuleType):
    def __init__(self, name: str, find: Callable[[str], object], kind: str) -> None:
        super().__init__(name)
        self._find = find
        self._kind = kind

    def __getattr__(self, name: str) -> object:
        if not name.startswith("_"):
            try:
                return self._find(f"{self.__name__.rpartition('.')[2]}/{name}")
            except RostetherError:
                pass
        raise AttributeError(f"module {self.__name__!r} has no {self._kind} {name!r}")
