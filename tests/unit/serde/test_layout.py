"""Whether bytes have a type's layout: accepted whole, and refused with a reason otherwise."""

from __future__ import annotations

import random
import struct

import pytest

from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import MAX_EMPTY_ELEMENTS
from unit.serde.definitions import store_of

STORE = TypeStore(Registry())


def u32(value: int) -> bytes:
    return struct.pack("<I", value)


def test_type_of_constant_size() -> None:
    layout = STORE.layout("geometry_msgs/Twist")
    assert layout.fixed_size_bytes == 48
    assert layout.accepts(bytes(48))
    assert not layout.accepts(bytes(47))
    assert not layout.accepts(bytes(49))


def test_type_without_fields() -> None:
    layout = STORE.layout("std_msgs/Empty")
    assert layout.fixed_size_bytes == 0
    assert layout.accepts(b"")
    assert not layout.accepts(b"\0")


def test_string() -> None:
    layout = STORE.layout("std_msgs/String")
    assert layout.fixed_size_bytes is None
    assert layout.accepts(u32(3) + b"abc")
    assert layout.accepts(u32(0))
    assert not layout.accepts(u32(3) + b"ab")
    assert not layout.accepts(u32(3) + b"abcd")
    assert not layout.accepts(b"\0\0\0")
    assert not layout.accepts(b"")


# Each as one message's field, the bytes of a value, and how many bytes of it a cut can spare: none.
VALUES = {
    "string[]": u32(2) + u32(1) + b"a" + u32(0),
    "string[2]": u32(1) + b"a" + u32(0),
    "float64[]": u32(2) + bytes(16),
    "float64[100]": bytes(800),
    "uint8[]": u32(5) + bytes(5),
    "uint8[3]": bytes(3),
    "time[]": u32(2) + bytes(16),
    "duration[2]": bytes(16),
    "bool": b"\1",
    "Header": bytes(12) + u32(3) + b"map",
    "std_msgs/Header[]": u32(1) + bytes(12) + u32(3) + b"map",
    "std_msgs/Header[1]": bytes(12) + u32(3) + b"map",
    "geometry_msgs/Point[]": u32(1) + bytes(24),
    "geometry_msgs/Point[2]": bytes(48),
    "std_msgs/Empty[]": u32(7),
    "sensor_msgs/JointState": bytes(12) + u32(0) + u32(1) + u32(2) + b"ab" + u32(1) + bytes(8) + u32(0) * 2,
}


@pytest.mark.parametrize("before", ["", "string before\n"], ids=["first", "after_string"])
@pytest.mark.parametrize("after", ["", "int16 after\n", "string after\n"], ids=["last", "int16", "string"])
@pytest.mark.parametrize("field", VALUES)
def test_every_kind_of_field(field: str, before: str, after: str) -> None:
    layout = store_of(Kind=f"{before}{field} middle\n{after}").layout("test/Kind")
    payload = (u32(2) + b"hi" if before else b"") + VALUES[field]
    payload += {"": b"", "int16 after\n": b"\1\2", "string after\n": u32(0)}[after]
    assert layout.accepts(payload)
    assert layout.explain(payload) == "the payload fits test/Kind"
    for end in range(len(payload)):
        assert not layout.accepts(payload[:end])
        assert "early in field '" in layout.explain(payload[:end])
    assert not layout.accepts(payload + b"\0")
    assert layout.explain(payload + b"\0") == "the payload has 1 byte more than test/Kind"


@pytest.mark.parametrize("name", ["std_msgs/Byte", "std_msgs/String", "sensor_msgs/JointState"])
def test_batch_needs_every_payload_to_fit(name: str) -> None:
    codec = STORE.codec(name)
    good = codec.encode(codec.message_class())
    accepts_all = codec.layout.accepts_all
    assert accepts_all([])
    assert accepts_all([good])
    assert accepts_all([good] * 5)
    for bad in (good[:-1], good + b"\0", b""):
        assert not accepts_all([bad])
        for place in range(3):
            batch = [good, good]
            batch.insert(place, bad)
            assert not accepts_all(batch)


@pytest.mark.parametrize(
    ("name", "payload", "reason"),
    [
        ("std_msgs/Byte", bytes(6), "the payload has 5 bytes more than std_msgs/Byte"),
        (
            "std_msgs/String",
            u32(5) + b"ab",
            "the payload of 6 bytes ends 3 bytes early in field 'data' of std_msgs/String",
        ),
        (
            "geometry_msgs/Twist",
            bytes(9),
            "the payload of 9 bytes ends 7 bytes early in field 'linear.y' of geometry_msgs/Twist",
        ),
        (
            "tf2_msgs/TFMessage",
            u32(1) + bytes(12) + u32(100),
            "the payload of 20 bytes ends 100 bytes early in field 'transforms[0].header.frame_id'"
            " of tf2_msgs/TFMessage",
        ),
        (
            "std_msgs/UInt64",
            b"1234567",
            "the payload of 7 bytes ends 1 byte early in field 'data' of std_msgs/UInt64",
        ),
    ],
)
def test_explanation_names_the_place(name: str, payload: bytes, reason: str) -> None:
    assert STORE.layout(name).explain(payload) == reason


def test_elements_without_content_are_limited() -> None:
    layout = store_of(Many="std_msgs/Empty[] empties").layout("test/Many")
    assert layout.accepts(u32(MAX_EMPTY_ELEMENTS))
    assert not layout.accepts(u32(MAX_EMPTY_ELEMENTS + 1))
    assert not layout.accepts(u32(0xFFFFFFFF))
    assert "more than the limit of" in layout.explain(u32(0xFFFFFFFF))


@pytest.mark.parametrize(
    "name", ["string[]", "float64[]", "std_msgs/Header[]", "string[1000000]", "Deep[]", "Big[]"]
)
def test_huge_counts_are_refused_immediately(name: str) -> None:
    layout = store_of(
        Kind=f"{name} many\nstring after",
        Deep="std_msgs/Header[] a\nDeeper[] b",
        Deeper="string[] c",
        Big="uint8[16000000] a",
    ).layout("test/Kind")
    for payload in (b"\xff" * 4, b"\xff" * 64, u32(0xFFFFFFFF) + bytes(4096)):
        assert not layout.accepts(payload)
        assert "\n" not in layout.explain(payload)


def test_garbage_never_raises() -> None:
    noise = random.Random(7)
    layouts = [STORE.layout(name) for name in STORE.registry.messages()]
    for _ in range(40):
        payload = noise.randbytes(noise.choice((0, 1, 4, 5, 30, 200)))
        if noise.random() < 0.5:
            payload = bytes(byte & 3 for byte in payload)
        for layout in layouts:
            accepted = layout.accepts(payload)
            assert layout.accepts_all([payload]) is accepted
            assert ("fits" in layout.explain(payload)) is accepted


def test_types_within_types_do_not_double_the_source() -> None:
    texts = {f"L{level}": f"L{level - 1} a\nL{level - 1} b" for level in range(1, 15)}
    store = store_of(L0="string s\nstring t", **texts)
    payload = u32(0) * 2 * 2**14
    assert store.layout("test/L14").accepts(payload)
    assert not store.layout("test/L14").accepts(payload + b"\0")
    codec = store.codec("test/L14")
    assert codec.encode(codec.decode(payload)) == payload


@pytest.mark.parametrize(
    ("field", "size_bytes"),
    [
        ("float64 x", 8),
        ("string x", 4),
        ("string[] x", 4),
        ("string[3] x", 12),
        ("Header x\nint8 y", 17),
        ("std_msgs/String[2] x", 8),
    ],
)
def test_smallest_size(field: str, size_bytes: int) -> None:
    layout = store_of(Kind=field).layout("test/Kind")
    assert layout.type_name == "test/Kind"
    assert layout.smallest_size_bytes == size_bytes
    assert layout.accepts(bytes(size_bytes))


@pytest.mark.parametrize(
    ("type_name", "varies"),
    [
        ("sensor_msgs/LaserScan", False),
        ("std_msgs/String", False),
        ("visualization_msgs/MarkerArray", True),
        ("sensor_msgs/JointState", True),
    ],
)
def test_elements_of_varying_size_are_known(type_name: str, varies: bool) -> None:
    assert STORE.layout(type_name).has_varying_elements == varies
