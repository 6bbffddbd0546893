"""The client library with the messages that a sketch needs, generated into the cache."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.firmware.cache import BuildCache, digest
from rostether.firmware.libraries import Library, Origin, read_library

if TYPE_CHECKING:
    from rostether.msgdef.registry import Registry

_FACADE = "ros.h"
_FOLDERS = ("ros/", "tf/")
_TYPE_HEADER = re.compile(r"(\w+)/(\w+)\.h")
# The includes of ros.h itself.
_ALWAYS = frozenset(("rosserial_msgs", "std_msgs"))
_SKIPPED = "skipped.txt"
_PACKAGE = Path(__file__).parents[1]


class RosLibrary:
    """Generates the library for the headers requested so far.

    `packages` are the packages whose messages it has; `skipped` has the reasons for messages that could not
    be generated.
    """

    def __init__(self, cache: BuildCache, msg_paths: Sequence[Path]) -> None:
        self._cache = cache
        self._msg_paths = tuple(msg_paths)
        self.packages: frozenset[str] = frozenset()
        self.skipped: list[str] = []

    @cached_property
    def registry(self) -> Registry:
        """The definitions of `msg_paths`, of ROS_PACKAGE_PATH, and those in rostether."""
        from rostether.msgdef.registry import Registry

        return Registry.from_environment(msg_paths=self._msg_paths)

    def add_header(self, header: str) -> bool:
        """Add the package of a missing header; return whether the header belongs to this library."""
        match = _TYPE_HEADER.fullmatch(header)
        is_type = match is not None and self._knows(match[1], match[2])
        if match is not None and is_type:
            self.packages |= {match[1]}
        if is_type or header == _FACADE or header.startswith(_FOLDERS):
            self.packages |= _ALWAYS
            if header.startswith("tf/"):
                self.packages |= {"tf"}
            return True
        return False

    def write(self) -> Library:
        """Return the library with the packages requested so far.

        Raises CodegenError, DefinitionError, FirmwareError.
        """
        from rostether.codegen.arduino_library import write_library

        key = digest("ros_lib", sorted(self.packages), self.signature())
        if self._cache.find("ros_lib", key, "ros_lib/library.properties") is None:
            with self._cache.filling("ros_lib", key) as folder:
                written = write_library(folder, self.registry, packages=sorted(self.packages))
                (folder / _SKIPPED).write_text("\n".join(written.library.skipped), encoding="utf-8")
        self.skipped = self._cache.path("ros_lib", key, _SKIPPED).read_text(encoding="utf-8").splitlines()
        return read_library(self._cache.path("ros_lib", key, "ros_lib"), Origin.ROS)

    def signature(self) -> str:
        """Return a string that changes when the client library, its generator or a definition changes."""
        from rostether.codegen.library_source import client_library, library_files

        client = client_library()
        files = [client / each for each in library_files(client)]
        files += sorted((_PACKAGE / "codegen").rglob("*.py"))
        files += sorted((_PACKAGE / "msgdef" / "share").glob("*/*/*"))
        files += self._user_definitions()
        return digest([_state(each) for each in files])

    def _user_definitions(self) -> Iterator[Path]:
        if not self._msg_paths and not os.environ.get("ROS_PACKAGE_PATH"):
            return
        from rostether.msgdef.definition_files import Kind, find_definitions
        from rostether.packages.search_path import ros_package_path

        found = find_definitions(self._msg_paths, ros_package_path(os.environ))
        for _, files in sorted(found.items()):
            for kind in Kind:
                yield from files.of(kind).values()

    def _knows(self, package: str, name: str) -> bool:
        full_name = f"{package}/{name}"
        return full_name in self.registry.messages(package) or full_name in self.registry.services(package)


def _state(file: Path) -> tuple[str, int, int]:
    status = file.stat()
    return str(file), status.st_size, status.st_mtime_ns
