""".msg, .srv and full texts from connection headers: refused with file, line and column, or understood."""

from __future__ import annotations

import contextlib

from rostether.errors import RostetherError
from rostether.msgdef.full_text import split_full_text
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.parse_srv import parse_service


def seeds() -> list[bytes]:
    """Return definitions."""
    return [
        b"Header header\nfloat64[9] m # comment\nuint8 A=1\nstring S= text # stays\n",
        b"int32 a\nstring[] names\n---\nbool ok\ngeometry_msgs/Pose[3] poses\n",
        b"Header h\n" + b"=" * 80 + b"\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n",
    ]


def run(data: bytes) -> None:
    """Parse as all three."""
    text = data.decode("utf-8", "surrogateescape")
    for parse in (parse_message, parse_service):
        try:
            parse(text, package="pkg", name="pkg/Type", file="Type.msg")
        except RostetherError as error:
            assert "\n" not in str(error)
    with contextlib.suppress(RostetherError):
        split_full_text("pkg/Type", text)
