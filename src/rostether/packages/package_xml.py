"""Reads package.xml and manifest.xml. Any DTD is refused before it is expanded."""

from __future__ import annotations

import re

from msgspec import Struct, field

from rostether.errors import ConfigError
from rostether.mechanisms.xml_tree import XmlElement, parse_xml, place_first

# Real ones are a few KB; a larger file is not a package.xml.
MAX_PACKAGE_XML_BYTES = 1 << 20
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


class PackageXml(Struct, frozen=True):
    """One package's description; `dependencies` maps each package it names to the kinds of dependency."""

    name: str
    version: str = ""
    description: str = ""
    maintainers: tuple[str, ...] = ()
    licenses: tuple[str, ...] = ()
    dependencies: dict[str, frozenset[str]] = field(default_factory=dict)
    build_type: str = ""


def is_package_name(name: str) -> bool:
    """Return whether this is a legal package name: a letter, then letters, digits, `_` and `-`."""
    return _PACKAGE_NAME.fullmatch(name) is not None


def parse_package_xml(data: bytes, *, file: str = "package.xml", default_name: str = "") -> PackageXml:
    """Read a package.xml (formats 1 to 3) or, with `default_name`, a nameless rosbuild manifest.xml.

    Raises ConfigError for a file that is too large, is not XML, or has a DTD, an entity or no legal name.
    """
    root = parse_xml(
        data,
        file=file,
        max_bytes=MAX_PACKAGE_XML_BYTES,
        what="a package.xml",
        make_error=place_first(ConfigError, file),
    )
    if root.tag != "package":
        raise ConfigError(f"{file}: the root element is <{root.tag}>, not <package>")
    name = _text(root, "name") or default_name
    if not is_package_name(name):
        raise ConfigError(f"{file}: {name!r} is not a package name; correct <name>")
    dependencies: dict[str, set[str]] = {}
    for element in root.children:
        # rosbuild's <depend package="NAME"/>, or <exec_depend>NAME</exec_depend>.
        package = element.get("package") if element.tag == "depend" else None
        if element.tag in _DEPENDENCIES and (package := package or _folded(element)):
            dependencies.setdefault(package, set()).add(element.tag)
    export = root.first("export")
    return PackageXml(
        name=name,
        version=_text(root, "version"),
        description=_text(root, "description"),
        maintainers=tuple(map(_folded, root.all("maintainer"))),
        licenses=tuple(map(_folded, root.all("license"))),
        dependencies={package: frozenset(kinds) for package, kinds in dependencies.items()},
        build_type=_text(export, "build_type") if export is not None else "",
    )


def _text(parent: XmlElement, tag: str) -> str:
    """Return the text of the first child with a tag, empty if there is none."""
    child = parent.first(tag)
    return _folded(child) if child is not None else ""


def _folded(element: XmlElement) -> str:
    # A description may contain mark-up; the text inside it is part of the description.
    return " ".join(element.full_text.split())
