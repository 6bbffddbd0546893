""".msg, .srv and full texts from connection headers: refused with file, line and column, or parsed.

Limits are low. A parsed definition must respect them, and must not change if it is written and parsed again.
"""

from __future__ import annotations

import random

from fuzz.grammar import near
from fuzz.lowering import lowered
from rostether.errors import RostetherError
from rostether.msgdef import full_text, parse_msg
from rostether.msgdef.full_text import SEPARATOR, split_full_text
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.parse_srv import parse_service
from rostether.msgdef.spec import MessageSpec

MAX_TEXT_CHARACTERS, MAX_FIELDS, MAX_ARRAY_LENGTH, MAX_PARTS = 1500, 12, 1000, 5
_BITS = {
    "int8": 7,
    "int16": 15,
    "int32": 31,
    "int64": 63,
    "uint8": 8,
    "uint16": 16,
    "uint32": 32,
    "uint64": 64,
}


def seeds() -> list[bytes]:
    """Return definitions."""
    return [
        b"Header header\nfloat64[9] m # comment\nuint8 A=1\nstring S= text # stays\n",
        b"int32 a\nstring[] names\n---\nbool ok\ngeometry_msgs/Pose[3] poses\n",
        b"Header h\n" + b"=" * 80 + b"\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n",
    ]


def generate(source: random.Random) -> bytes:
    """Return declarations whose numbers of fields, parts and elements are near and above the limits."""
    lines = []
    for number in range(near(source, MAX_FIELDS) % 20):
        if source.random() < 0.25:
            lines.append(_constant(source, number))
            continue
        base = source.choice(
            ("int8", "string", "time", "Header", "pkg/Name", "Name", "float64", "bool", "x y")
        )
        length = str(near(source, MAX_ARRAY_LENGTH)) if source.random() < 0.3 else ""
        brackets = f"[{length}]" if source.random() < 0.4 else ""
        name = f"f{number}" if source.random() < 0.93 else source.choice(("f0", "2x", "a-b", ""))
        lines.append(f"{base}{brackets} {name}" + source.choice(("", "", " # said")))
    text = "\n".join(lines)
    chance = source.random()
    if chance < 0.2:
        parts = near(source, MAX_PARTS) % 10
        text += "".join(f"\n{SEPARATOR}\nMSG: pkg/P{number}\nint8 a" for number in range(parts))
    elif chance < 0.4:
        text += "\n---\nbool ok\n"
    elif chance < 0.5:
        text += "\n#" + "x" * (near(source, MAX_TEXT_CHARACTERS) % 3000)
    return text.encode()


def _constant(source: random.Random, number: int) -> str:
    base = source.choice((*_BITS, "float32", "bool", "string", "time"))
    limit = 1 << _BITS.get(base, 8)
    value = source.choice((limit - 1, limit, -limit, -limit - 1, 0, -1, "True", "1e3", "", "9" * 30))
    return f"{base} C{number}={value}"


def run(data: bytes) -> None:
    """Parse the data in all three forms."""
    limits = {"MAX_TEXT_CHARACTERS": MAX_TEXT_CHARACTERS, "MAX_FIELDS": MAX_FIELDS}
    with (
        lowered(parse_msg, MAX_ARRAY_LENGTH=MAX_ARRAY_LENGTH, **limits),
        lowered(full_text, MAX_PARTS=MAX_PARTS),
    ):
        _parse(data.decode("utf-8", "surrogateescape"))


def _parse(text: str) -> None:
    try:
        spec = parse_message(text, package="pkg", name="pkg/Type", file="Type.msg")
    except RostetherError as error:
        assert "\n" not in str(error)
    else:
        assert len(text) <= MAX_TEXT_CHARACTERS, "a text longer than allowed"
        _check(spec)
    try:
        service = parse_service(text, package="pkg", name="pkg/Type", file="Type.srv")
    except RostetherError as error:
        assert "\n" not in str(error)
    else:
        _check(service.request)
        _check(service.response)
    try:
        parts = split_full_text("pkg/Type", text)
    except RostetherError:
        return
    assert len(parts) <= MAX_PARTS + 1, "more parts than allowed"
    assert text.count(SEPARATOR) >= len(parts) - 1, "more parts than are marked"


def _check(spec: MessageSpec) -> None:
    names = [field.name for field in spec.fields]
    assert len(names) <= MAX_FIELDS, "more fields than allowed"
    assert len(set(names)) == len(names), "a field is declared twice"
    for field in spec.fields:
        assert field.name.isascii()
        assert field.name.isidentifier()
        assert field.type.length is None or field.type.length <= MAX_ARRAY_LENGTH, (
            "a longer array than allowed"
        )
    for constant in spec.constants:
        bits = _BITS.get(constant.type)
        if bits is not None:
            assert isinstance(constant.value, int)
            low = 0 if constant.type.startswith("u") else -(1 << bits)
            assert low <= constant.value < 1 << bits, "a constant beyond its type"
    again = parse_message(spec.text, package="pkg", name="pkg/Type", file="Type.msg")
    assert again.fields == spec.fields
