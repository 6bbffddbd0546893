"""The text of a launch file as a tree of elements."""

from __future__ import annotations

from rostether.errors import LaunchError
from rostether.mechanisms.xml_tree import XmlElement, parse_xml

# A launch file may contain a URDF or parameters; real ones are much smaller than 16 MB.
MAX_FILE_BYTES = 1 << 24


def parse_launch_xml(data: bytes, *, file: str) -> XmlElement:
    """Return the root element of a launch file, <launch>.

    Raises LaunchError with file and line if the text is too large, is not XML, has a DTD or an entity, or
    has another root.
    """
    if file.endswith(".launch.py"):
        raise LaunchError(
            "a ROS 2 launch file in Python, and only ROS 1 launch files in XML can be read; start it with "
            "`ros2 launch`",
            file=file,
        )
    root = parse_xml(
        data,
        file=file,
        max_bytes=MAX_FILE_BYTES,
        what="a launch file",
        make_error=lambda text, line: LaunchError(text, file=file, line=line),
    )
    if root.tag != "launch":
        raise root.error(f"the root element is <{root.tag}>, not <launch>")
    return root
