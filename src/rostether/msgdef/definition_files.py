"""Finds .msg, .srv and .action texts: in packages on disk, in plain folders, and the bundled ones.

A package's definitions are in its `msg`, `srv` and `action` folders or directly in its root. Outside of any
package, `X/Foo.msg` and `X/msg/Foo.msg` are X/Foo. Folders are read on first use.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Iterator, Mapping
from enum import StrEnum
from pathlib import Path

from rostether.errors import ConfigError, DefinitionError
from rostether.msgdef.parse_msg import MAX_TEXT_CHARACTERS
from rostether.packages.package_xml import is_package_name
from rostether.packages.search_path import Folder, package_name, walk

BUNDLED_FOLDER = Path(__file__).with_name("share")

_TYPE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


class Kind(StrEnum):
    """The three kinds of definition; the value is both the file's suffix and its folder's usual name."""

    MESSAGE = "msg"
    SERVICE = "srv"
    ACTION = "action"


_KIND_FOLDERS = frozenset(Kind)


def existing_folders(msg_paths: Iterable[Path | str]) -> list[Path]:
    """Return the folders of --msg-path. Raises ConfigError for a missing one."""
    paths = [Path(path).expanduser() for path in msg_paths]
    for path in paths:
        if not path.is_dir():
            raise ConfigError(
                f"--msg-path {path}: no such folder; give a folder of packages or of .msg files"
            )
    return paths


def is_type_name(name: str) -> bool:
    """Return whether a message, service or action may have this name, without its package."""
    return _TYPE_NAME.fullmatch(name) is not None


class PackageFiles:
    """The definition files of one package: kind -> type name -> file, gathered from one or more folders."""

    def __init__(self) -> None:
        self._roots: list[Path] = []
        self._files: dict[Kind, dict[str, Path]] | None = None
        self._loose: list[tuple[Path, frozenset[str]]] = []

    def add_root(self, root: Path) -> None:
        """Add a package's root; its subfolders are read later."""
        self._roots.append(root)
        self._files = None

    def add_loose(self, folder: Path, files: frozenset[str]) -> None:
        """Add the files of one folder that was already read."""
        self._loose.append((folder, files))
        self._files = None

    @property
    def root(self) -> Path | None:
        """The folder of the package; None for a plain folder, or without definitions."""
        return self._roots[0] if self._roots and any(map(self.of, Kind)) else None

    def of(self, kind: Kind) -> Mapping[str, Path]:
        """Return the files of a kind by type name."""
        if self._files is None:
            self._files = {each: {} for each in Kind}
            for folder, files in [*self._folders(), *self._loose]:
                for file in sorted(files):
                    self._add(folder, file)
        return self._files[kind]

    def _folders(self) -> Iterator[tuple[Path, frozenset[str]]]:
        for root in self._roots:
            for kind in Kind:
                for folder in walk(root / kind, below_packages=True):
                    yield folder.path, folder.files
            try:
                yield root, frozenset(entry.name for entry in root.iterdir() if _is_definition(entry.name))
            except OSError:
                continue

    def _add(self, folder: Path, file: str) -> None:
        name, _, suffix = file.rpartition(".")
        if suffix in _KIND_FOLDERS and is_type_name(name) and self._files is not None:
            self._files[Kind(suffix)].setdefault(name, folder / file)


def find_definitions(msg_paths: Iterable[Path], package_path: Iterable[Path]) -> dict[str, PackageFiles]:
    """Return the files of packages below both, and of plain folders below `msg_paths`, by package name.

    Earlier folders have priority.
    """
    found: dict[str, PackageFiles] = {}
    for root in msg_paths:
        for folder in walk(root):
            if folder.is_package:
                # The user named this folder: a broken package.xml must not hide its definitions.
                _add_package(found, package_name(folder.path) or folder.path.name, folder)
            elif any(map(_is_definition, folder.files)):
                _add_loose(found, folder)
    for root in package_path:
        for folder in walk(root):
            if folder.is_package and (name := package_name(folder.path)):
                _add_package(found, name, folder)
    return found


# Boards and peers can invent any number of package names.
MAX_LISTED_PACKAGES = 1024


@functools.cache
def bundled_packages() -> frozenset[str]:
    """Return the names of the packages with bundled definitions."""
    return frozenset(entry.name for entry in BUNDLED_FOLDER.iterdir() if entry.is_dir())


@functools.lru_cache(maxsize=MAX_LISTED_PACKAGES)
def bundled_names(package: str, kind: Kind) -> frozenset[str]:
    """Return the type names of one kind that are bundled for a package; empty for an unknown package."""
    if package not in bundled_packages():
        return frozenset()
    try:
        return frozenset(entry.stem for entry in (BUNDLED_FOLDER / package / kind).iterdir())
    except OSError:
        return frozenset()


def bundled_file(package: str, kind: Kind, name: str) -> Path | None:
    """Return the file of a bundled definition, or None."""
    # Looked up in the listing: some file systems would also find Name under `name`.
    if name not in bundled_names(package, kind):
        return None
    return BUNDLED_FOLDER / package / kind / f"{name}.{kind}"


def earlier_files(package: str, name: str) -> dict[str, Path]:
    """Return the bundled definitions of a message in earlier versions of its package, newest first.

    The files are `earlier/Name.VERSION.msg` in the package's folder.
    """
    if package not in bundled_packages():
        return {}
    files = (BUNDLED_FOLDER / package / "earlier").glob("*.msg")
    found = {file.stem.partition(".")[2]: file for file in files if file.stem.partition(".")[0] == name}
    return dict(sorted(found.items(), reverse=True))


def read_definition(file: Path) -> str:
    """Return a file's text with Unix line ends. Raises DefinitionError if it cannot be read or is too long.

    Comments may have any encoding, so bytes that are not UTF-8 are replaced.
    """
    if file.exists() and not file.is_file():
        # Opening a FIFO may never return.
        raise DefinitionError("is not a file with a definition; remove it", file=str(file))
    try:
        with file.open("rb") as stream:
            data = stream.read(MAX_TEXT_CHARACTERS + 1)
    except OSError as error:
        raise DefinitionError(f"cannot be read: {error.strerror}", file=str(file)) from error
    if len(data) > MAX_TEXT_CHARACTERS:
        raise DefinitionError(
            f"the definition is longer than {MAX_TEXT_CHARACTERS} bytes; split it", file=str(file)
        )
    text = data.decode("utf-8-sig", errors="replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _is_definition(file: str) -> bool:
    return file.endswith((".msg", ".srv", ".action"))


def _add_package(found: dict[str, PackageFiles], name: str, folder: Folder) -> None:
    found.setdefault(name, PackageFiles()).add_root(folder.path)


def _add_loose(found: dict[str, PackageFiles], folder: Folder) -> None:
    owner = folder.path
    if owner.name in _KIND_FOLDERS:
        owner = owner.parent
    # The user may have given the msg folder of a real package.
    name = (package_name(owner) if owner != folder.path else None) or owner.name
    if is_package_name(name):
        found.setdefault(name, PackageFiles()).add_loose(folder.path, folder.files)
