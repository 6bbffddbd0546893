"""Reads package.xml and manifest.xml. DTDs and entities are rejected before they are expanded."""

from __future__ import annotations

import re
from pathlib import Path

from msgspec import Struct, field

from rostether.errors import ConfigError
from rostether.mechanisms.text import read_failure
from rostether.mechanisms.xml_tree import XmlElement, parse_xml, place_first

PACKAGE_FILE = "package.xml"

# The older description of rosbuild, which has no name: the package has the name of its folder.
ROSBUILD_FILE = "manifest.xml"

# Real descriptions are a few KB.
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
    """The description of a package; `dependencies` maps package names to the tags that name them."""

    name: str
    version: str = ""
    description: str = ""
    maintainers: tuple[str, ...] = ()
    licenses: tuple[str, ...] = ()
    dependencies: dict[str, frozenset[str]] = field(default_factory=dict)
    build_type: str = ""


def is_package_name(name: str) -> bool:
    """Return whether a package may have this name: a letter, then letters, digits, `_` and `-`."""
    return _PACKAGE_NAME.fullmatch(name) is not None


def is_package(folder: Path) -> bool:
    """Return whether a folder is the root of a package."""
    return (folder / PACKAGE_FILE).is_file() or (folder / ROSBUILD_FILE).is_file()


def read_package_xml(folder: Path) -> PackageXml:
    """Read the package.xml of a package, or its manifest.xml.

    Raises ConfigError as `parse_package_xml` does, and for a file that cannot be read.
    """
    file, default_name = folder / PACKAGE_FILE, ""
    if not file.is_file():
        file, default_name = folder / ROSBUILD_FILE, folder.name
    try:
        with file.open("rb") as stream:
            data = stream.read(MAX_PACKAGE_XML_BYTES + 1)
    except OSError as error:
        raise ConfigError(read_failure(file, error)) from None
    return parse_package_xml(data, file=str(file), default_name=default_name)


def parse_package_xml(data: bytes, *, file: str = PACKAGE_FILE, default_name: str = "") -> PackageXml:
    """Read the text of a package.xml (formats 1 to 3) or manifest.xml.

    `default_name` is the name if the text has none, as in a manifest.xml. Raises ConfigError for a text that
    is too large, is not XML, or has a DTD, an entity or no legal name.
    """
    root = parse_xml(
        data,
        file=file,
        max_bytes=MAX_PACKAGE_XML_BYTES,
        what="a package.xml",
        make_error=place_first(ConfigError, file),
    )
    if root.tag != "package":
        raise ConfigError(f"{file}: the root element is <{root.tag}>, not <package>; write a package.xml")
    name = _text(root, "name") or default_name
    if not name:
        raise ConfigError(f"{file}: the package has no name; add <name>NAME</name>")
    if not is_package_name(name):
        raise ConfigError(f"{file}: {name!r} is not a package name; correct <name>")
    dependencies: dict[str, set[str]] = {}
    for element in root.children:
        # rosbuild writes <depend package="NAME"/>, catkin <exec_depend>NAME</exec_depend>.
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
    """Return the text of the first child with a tag; empty if there is none."""
    child = parent.first(tag)
    return _folded(child) if child is not None else ""


def _folded(element: XmlElement) -> str:
    # A description may contain mark-up; the text inside it is part of the description.
    return " ".join(element.full_text.split())
