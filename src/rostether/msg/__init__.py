"""The bundled messages as classes: `from rostether.msg.std_msgs import String`.

Type checkers know their fields, which are those of ROS 1. A workspace's own messages have no classes here:
name them by type (`"my_msgs/Speed"`).
"""

from __future__ import annotations

import sys
from functools import cache
from types import ModuleType

from rostether.errors import RostetherError
from rostether.msgdef.definition_files import bundled_packages
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore


@cache
def _store() -> TypeStore:
    return TypeStore(Registry())


class _Package(ModuleType):
    def __getattr__(self, name: str) -> object:
        if not name.startswith("_"):
            try:
                return _store().codec(f"{self.__name__.rpartition('.')[2]}/{name}").message_class
            except RostetherError:
                pass
        raise AttributeError(f"module {self.__name__!r} has no message {name!r}")


def _add_packages() -> None:
    for package in bundled_packages():
        module = _Package(f"{__name__}.{package}")
        # So that the import statement finds them.
        sys.modules[module.__name__] = module
        globals()[package] = module


_add_packages()
