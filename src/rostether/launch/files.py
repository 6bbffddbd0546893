"""Reads the files of a launch: launch files as trees of elements, and files for parameters."""

from __future__ import annotations

from rostether.errors import LaunchError
from rostether.mechanisms.text import read_failure
from rostether.mechanisms.xml_tree import XmlElement, parse_xml

# A launch file may contain a URDF or parameters; real ones are much smaller than 16 MB.
MAX_FILE_BYTES = 1 << 24

# Represents the folder of built-in packages, which have no files.
BUILTIN_ROOT = "/rostether-built-in"


def read_file(file: str) -> bytes:
    """Return the content of a file, or its first MAX_FILE_BYTES + 1 bytes. Raises LaunchError."""
    try:
        with open(file, "rb") as stream:  # noqa: PTH123 - Path("") would be "."
            return stream.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        if file.startswith(f"{BUILTIN_ROOT}/"):
            package = file.removeprefix(f"{BUILTIN_ROOT}/").partition("/")[0]
            raise LaunchError(
                f"package {package} is not installed; its nodes are built in, but it has no files here"
            ) from None
        raise LaunchError(read_failure(repr(file), error)) from None


def parse_launch_xml(data: bytes, *, file: str) -> XmlElement:
    """Return the root element of a launch file, <launch>. `file` is its path, for errors.

    Raises LaunchError with file and line if the text is too large, is not XML, has a DTD or an entity, or
    has another root element.
    """
    if file.endswith((".launch.py", ".launch.yaml", ".launch.yml")):
        raise LaunchError(
            "this is a launch file of ROS 2, not one of ROS 1 in XML; start it with `ros2 launch`", file=file
        )
    root = parse_xml(
        data,
        file=file,
        max_bytes=MAX_FILE_BYTES,
        what="a launch file",
        make_error=lambda text, line: LaunchError(text, file=file, line=line),
    )
    if root.tag != "launch":
        raise root.error(f"the root element is <{root.tag}>, not <launch>; give a ROS 1 launch file")
    return root
