"""package.xml and manifest.xml: which package a folder is. Any DTD is refused before it is expanded."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from xml.parsers import expat

from rostether.errors import ConfigError

MAX_PACKAGE_XML_BYTES = 1 << 20  # real ones are a few KB; a larger file is not a package.xml
_MAX_DEPTH = 64  # exports nest a few levels; a bound keeps a hostile file from growing the stack
_PACKAGE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
_DEPENDENCIES = frozenset(
    {
        "depend",
        "build_depend",
        "build_export_depend",
        "buildtool_depend",
        "buildtool_export_depend",
        "exec_depend",
        "run_depend",
        "test_depend",
        "doc_depend",
    }
)


@dataclass(frozen=True, slots=True)
class PackageXml:
    """One package's description; `dependencies` maps each package it names to the kinds of dependency."""

    name: str
    version: str = ""
    description: str = ""
    maintainers: tuple[str, ...] = ()
    licenses: tuple[str, ...] = ()
    dependencies: dict[str, frozenset[str]] = field(default_factory=dict)
    build_type: str = ""


def is_package_name(name: str) -> bool:
    """Tell whether a package may be called so: a letter, then letters, digits, `_` and `-`."""
    return _PACKAGE_NAME.fullmatch(name) is not None


def parse_package_xml(data: bytes, *, file: str = "package.xml", default_name: str = "") -> PackageXml:
    """Read a package.xml (formats 1 to 3) or, with `default_name`, a nameless rosbuild manifest.xml.

    Raises ConfigError: too large, not XML, a DTD or entity, no or a bad package name.
    """
    if len(data) > MAX_PACKAGE_XML_BYTES:
        raise ConfigError(f"{file}: larger than {MAX_PACKAGE_XML_BYTES} bytes, not a package.xml")
    reader = _Reader(file)
    reader.read(data)
    name = "".join(reader.texts.get("name", ())[:1]) or default_name
    if not is_package_name(name):
        raise ConfigError(f"{file}: {name!r} is not a package name; give one in <name>")
    dependencies: dict[str, set[str]] = {}
    for kind, package in reader.dependencies:
        dependencies.setdefault(package, set()).add(kind)
    return PackageXml(
        name=name,
        version=_first(reader, "version"),
        description=_first(reader, "description"),
        maintainers=tuple(reader.texts.get("maintainer", ())),
        licenses=tuple(reader.texts.get("license", ())),
        dependencies={package: frozenset(kinds) for package, kinds in dependencies.items()},
        build_type=_first(reader, "export/build_type"),
    )


def _first(reader: _Reader, path: str) -> str:
    return next(iter(reader.texts.get(path, ())), "")


class _Reader:
    """Collects the texts of the document's elements by their path below the root."""

    def __init__(self, file: str) -> None:
        self.texts: dict[str, list[str]] = {}
        self.dependencies: list[tuple[str, str]] = []
        self._file = file
        self._path: list[str] = []
        self._text: list[list[str]] = []

    def read(self, data: bytes) -> None:
        parser = expat.ParserCreate()
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.StartDoctypeDeclHandler = self._refuse_dtd
        parser.EntityDeclHandler = self._refuse_dtd
        try:
            parser.Parse(data, True)
        except expat.ExpatError as error:
            raise ConfigError(
                f"{self._file}:{error.lineno}: not XML ({expat.ErrorString(error.code)})"
            ) from error

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if len(self._path) >= _MAX_DEPTH:
            raise ConfigError(f"{self._file}: elements nest deeper than {_MAX_DEPTH}")
        if not self._path and tag != "package":
            raise ConfigError(f"{self._file}: the outermost element is <{tag}>, not <package>")
        if len(self._path) == 1 and tag == "depend" and "package" in attributes:
            self.dependencies.append((tag, attributes["package"]))
        self._path.append(tag)
        self._text.append([])

    def _characters(self, text: str) -> None:
        # A description holds mark-up, so a text also counts for the elements around it.
        for pieces in self._text[1:]:
            pieces.append(text)

    def _end(self, tag: str) -> None:
        text = " ".join("".join(self._text.pop()).split())
        path = "/".join(self._path[1:])
        self._path.pop()
        self.texts.setdefault(path, []).append(text)
        if path in _DEPENDENCIES and text:
            self.dependencies.append((path, text))

    def _refuse_dtd(self, *_: object) -> None:
        raise ConfigError(f"{self._file}: declares a DTD or an entity, which is not allowed; remove it")
