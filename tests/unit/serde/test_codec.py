"""Values to bytes and back, and what is said about values and bytes that do not fit."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from typing import Any

import pytest

from rostether.errors import SerializationError
from rostether.msgdef.registry import Registry
from rostether.rostime import Duration, Time
from rostether.serde.encoder_source import to_bytes
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import MAX_EMPTY_ELEMENTS
from unit.serde.definitions import store_of

STORE = TypeStore(Registry())


def u32(value: int) -> bytes:
    return struct.pack("<I", value)


def test_wire_form_of_a_string() -> None:
    codec = STORE.codec("std_msgs/String")
    assert codec.encode({"data": "héllo"}) == u32(6) + b"h\xc3\xa9llo"
    assert codec.decode(u32(6) + b"h\xc3\xa9llo").data == "héllo"


EVERYTHING = """
bool a
int8 b
uint16 c
int64 d
float32 e
string f
time g
duration h
uint8[] i
char[2] j
int16[] k
float32[2] l
string[] m
time[] n
std_msgs/Empty[] o
std_msgs/UInt8[] p
bool[] q
bool[2] r
uint8[0] s
std_msgs/Empty t
std_msgs/String[1] u
duration[1] v
std_msgs/Empty[1] w
std_msgs/UInt8[2] x
string[1] y
string[0] z
"""


def test_wire_form_of_everything() -> None:
    codec = store_of(All=EVERYTHING).codec("test/All")
    fields: dict[str, Any] = {
        "a": True, "b": -1, "c": 0xABCD, "d": -2, "e": 1.5, "f": "x", "g": Time(1, 2), "h": Duration(-1, 5),
        "i": b"\1\2", "j": b"yz", "k": [-1, 2], "l": [0.5, -0.5], "m": ["a", ""], "n": [Time(3, 4)],
        "o": [{}, {}], "p": [{"data": 7}], "q": [True, False], "r": [False, True], "s": b"", "t": {},
        "u": [{"data": "u"}], "v": [Duration(5, 6)], "w": [{}], "x": [{"data": 8}, {"data": 9}], "y": ["why"],
        "z": [],
    }  # fmt: skip
    expected = b"".join(
        [
            struct.pack("<?bHqf", True, -1, 0xABCD, -2, 1.5),
            u32(1) + b"x" + struct.pack("<IIii", 1, 2, -1, 5),
            u32(2) + b"\1\2" + b"yz",
            u32(2) + struct.pack("<hh", -1, 2) + struct.pack("<ff", 0.5, -0.5),
            u32(2) + u32(1) + b"a" + u32(0),
            u32(1) + struct.pack("<II", 3, 4) + u32(2) + u32(1) + b"\7",
            u32(2) + b"\1\0" + b"\0\1" + u32(1) + b"u",
            struct.pack("<ii", 5, 6) + b"\10\11" + u32(3) + b"why",
        ]
    )
    assert codec.encode(fields) == expected
    message = codec.decode(expected)
    assert message == codec.conform(fields)
    assert codec.encode(message) == expected
    assert type(message.g) is Time
    assert type(message.v[0]) is Duration
    assert type(message.i) is bytes


@pytest.mark.parametrize("length", [1, 64, 65, 500])
def test_fixed_arrays_of_any_length(length: int) -> None:
    store = store_of(
        A=f"int32 before\nfloat32[{length}] values\nbool[{length}] flags\nint8 after", B="A[] many"
    )
    values = {
        "before": 1,
        "values": [float(i) for i in range(length)],
        "flags": [i % 3 == 0 for i in range(length)],
    }
    codec = store.codec("test/A")
    message = codec.decode(codec.encode({**values, "after": 2}))
    assert (message.values, message.flags, message.after) == (values["values"], values["flags"], 2)
    many = store.codec("test/B")
    assert many.decode(many.encode({"many": [message, message]})).many == [message, message]


def test_a_large_struct_is_read() -> None:
    wide = "\n".join(f"int16 x{place}" for place in range(700))
    store = store_of(Wide=wide, Long=f"{wide}\nstring s", Both="Wide w\nLong l\nWide[] many\nint8 end")
    codec = store.codec("test/Both")
    message = codec.message_class(end=-1)
    message.w.x699, message.l.x0, message.l.s = 1, 2, "s"
    message.many = [message.w]
    assert codec.decode(codec.encode(message)) == message
    assert codec.layout.accepts(codec.encode(message))


def test_an_array_that_is_read_in_steps() -> None:
    codec = store_of(Kind="int16[] many\nint16 last").codec("test/Kind")
    numbers = [number % 30_000 for number in range(150_001)]
    message = codec.decode(codec.encode({"many": numbers, "last": -1}))
    assert (message.many, message.last) == (numbers, -1)


def test_bytes_that_are_not_utf8_survive() -> None:
    codec = STORE.codec("std_msgs/String")
    payload = u32(4) + b"\xff\xfe\x80a"
    assert codec.decode(payload).data == "\udcff\udcfe\udc80a"
    assert codec.encode(codec.decode(payload)) == payload
    assert codec.encode({"data": b"\xff\xfe\x80a"}) == payload


@pytest.mark.parametrize("value", [math.inf, -math.inf, -0.0, 5e-324, 1.7976931348623157e308])
def test_floats_are_exact(value: float) -> None:
    codec = STORE.codec("std_msgs/Float64")
    again = codec.decode(codec.encode({"data": value})).data
    assert math.copysign(1, again) == math.copysign(1, value)
    assert again == value


def test_nan_is_kept() -> None:
    codec = STORE.codec("std_msgs/Float32")
    assert math.isnan(codec.decode(codec.encode({"data": math.nan})).data)


def test_messages_may_hold_looser_values() -> None:
    codec = STORE.codec("sensor_msgs/Imu")
    message = codec.message_class(
        header={"frame_id": "imu"}, orientation={"w": 1}, orientation_covariance=tuple(range(9))
    )
    decoded = codec.decode(codec.encode(message))
    assert decoded.header.frame_id == "imu"
    assert decoded.orientation.w == 1.0
    assert decoded.orientation_covariance == [float(i) for i in range(9)]
    image = STORE.codec("sensor_msgs/Image")
    for data in ([1, 2], (1, 2), bytearray(b"\1\2"), memoryview(b"\1\2")):
        assert image.decode(image.encode({"data": data})).data == b"\1\2"


FLAG = "a bool (true or false)"
OCTETS = "bytes or a list of integers from 0 to 255 (uint8[])"
WRONG: list[tuple[str, dict[str, Any], str, str]] = [
    ("geometry_msgs/Twist", {"linear": {"x": "abc"}}, "linear.x", "a float64, got 'abc'"),
    ("geometry_msgs/Twist", {"linear": [1]}, "linear", "a geometry_msgs/Vector3 or a mapping of its fields"),
    ("std_msgs/UInt8", {"data": 256}, "data", "a uint8 (0 to 255), got 256"),
    ("std_msgs/UInt8", {"data": -1}, "data", "a uint8 (0 to 255), got -1"),
    ("std_msgs/Byte", {"data": 128}, "data", "a byte (-128 to 127), got 128"),
    ("std_msgs/Int16", {"data": 1.0}, "data", "an int16 (-32768 to 32767), got 1.0"),
    ("std_msgs/Float32", {"data": 1e39}, "data", "a float32, got 1e+39"),
    ("std_msgs/Float64", {"data": 10**400}, "data", "a float64, got 1000"),
    ("std_msgs/Bool", {"data": "false"}, "data", f"{FLAG}, got 'false'"),
    ("std_msgs/Bool", {"data": 2}, "data", f"{FLAG}, got 2"),
    ("std_msgs/Bool", {"data": []}, "data", f"{FLAG}, got []"),
    ("std_msgs/String", {"data": 5}, "data", "a string, got 5"),
    ("std_msgs/String", {"data": "\ud800"}, "data", "a string that UTF-8 can encode, got '\\ud800'"),
    ("std_msgs/Header", {"stamp": 1.5}, "stamp", "a time (secs and nsecs, each uint32), got 1.5"),
    ("std_msgs/Header", {"stamp": Time(-1, 0)}, "stamp", "a time (secs and nsecs, each uint32), got Time("),
    ("std_msgs/Duration", {"data": (1, 2)}, "data", "a duration (secs and nsecs, each int32), got (1, 2)"),
    ("sensor_msgs/MagneticField", {"magnetic_field_covariance": [0.0] * 8}, "magnetic_field_covariance",
     "9 elements (float64[9]), got 8"),
    ("sensor_msgs/LaserScan", {"ranges": [1.0, None]}, "ranges[1]", "a float32, got None"),
    ("sensor_msgs/LaserScan", {"ranges": "12"}, "ranges", "a list (float32[]), got '12'"),
    ("sensor_msgs/JointState", {"name": "ab"}, "name", "a list (string[]), got 'ab'"),
    ("sensor_msgs/Image", {"data": [1, 300]}, "data[1]", "a uint8 (0 to 255), got 300"),
    ("sensor_msgs/Image", {"data": "ab"}, "data", f"{OCTETS}, got 'ab'"),
    ("sensor_msgs/Image", {"data": 5}, "data", f"{OCTETS}, got 5"),
    ("tf2_msgs/TFMessage", {"transforms": [{}, {"header": {"seq": -1}}]}, "transforms[1].header.seq",
     "a uint32 (0 to 4294967295), got -1"),
]  # fmt: skip


@pytest.mark.parametrize("form", ["mapping", "message"])
@pytest.mark.parametrize(("name", "value", "field", "wants"), WRONG)
def test_a_value_that_does_not_fit_is_named(
    name: str, value: dict[str, Any], field: str, wants: str, form: str
) -> None:
    codec = STORE.codec(name)
    with pytest.raises(SerializationError) as error:
        codec.encode(value if form == "mapping" else codec.message_class(**value))
    text = str(error.value)
    assert text.startswith(f"field '{field}' of {name} needs {wants}")
    assert "\n" not in text
    assert len(text) < 250


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("std_msgs/String", {"dta": "x"}, "std_msgs/String has no field 'dta'; it has data"),
        ("std_msgs/Empty", {"data": 1}, "std_msgs/Empty has no field 'data'; it has no fields"),
        (
            "geometry_msgs/Twist",
            {"linear": {"w": 1}},
            "geometry_msgs/Twist.linear has no field 'w'; it has x, y, z",
        ),
        (
            "std_msgs/Header",
            {"stamp": {"sec": 1}},
            "std_msgs/Header.stamp has no field 'sec'; it has secs, nsecs",
        ),
        ("std_msgs/String", {5: "x"}, "std_msgs/String has no field 5; it has data"),
    ],
)
def test_unknown_fields_are_named(name: str, value: dict[str, Any], text: str) -> None:
    with pytest.raises(SerializationError) as error:
        STORE.codec(name).encode(value)
    assert str(error.value) == text


def test_array_lengths_that_add_up_are_still_wrong() -> None:
    codec = STORE.codec("sensor_msgs/Imu")
    message = codec.message_class(orientation_covariance=[0.0] * 8, angular_velocity_covariance=[0.0] * 10)
    with pytest.raises(SerializationError, match="'orientation_covariance'"):
        codec.encode(message)


def test_message_of_another_type() -> None:
    with pytest.raises(
        SerializationError, match="std_msgs/String needs a std_msgs/String, got 'std_msgs/Bool'"
    ):
        STORE.codec("std_msgs/String").encode(STORE.codec("std_msgs/Bool").message_class())
    with pytest.raises(SerializationError, match="std_msgs/String needs"):
        STORE.codec("std_msgs/String").encode(5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "name", ["std_msgs/String", "std_msgs/UInt32", "sensor_msgs/JointState", "std_msgs/Empty"]
)
def test_bytes_of_another_length_are_explained(name: str) -> None:
    codec = STORE.codec(name)
    payload = codec.encode(codec.message_class())
    with pytest.raises(SerializationError, match=f"more than {name}"):
        codec.decode(payload + b"\0")
    for end in range(len(payload)):
        with pytest.raises(SerializationError, match=f"early in field '.*' of {name}"):
            codec.decode(payload[:end])


def test_announced_lengths_allocate_nothing() -> None:
    for field in (
        "string",
        "uint8[]",
        "float64[]",
        "string[]",
        "std_msgs/Header[]",
        "time[]",
        "geometry_msgs/Point[]",
    ):
        codec = store_of(Kind=f"{field} many\nint8 after").codec("test/Kind")
        with pytest.raises(SerializationError, match="bytes early in field 'many"):
            codec.decode(u32(0xFFFFFFFF) + bytes(8))


def test_elements_without_content_are_limited() -> None:
    codec = store_of(Many="std_msgs/Empty[] empties").codec("test/Many")
    assert len(codec.decode(u32(MAX_EMPTY_ELEMENTS)).empties) == MAX_EMPTY_ELEMENTS
    with pytest.raises(SerializationError, match="more than the limit of"):
        codec.decode(u32(MAX_EMPTY_ELEMENTS + 1))
    with pytest.raises(SerializationError, match="needs at most 256 elements, got 257"):
        codec.encode({"empties": [{}] * (MAX_EMPTY_ELEMENTS + 1)})
    nested = store_of(Many="Pair[] pairs", Pair="std_msgs/Empty a\nstd_msgs/Empty b").codec("test/Many")
    assert len(nested.decode(u32(MAX_EMPTY_ELEMENTS // 3)).pairs) == MAX_EMPTY_ELEMENTS // 3
    with pytest.raises(SerializationError, match="more than the limit of"):
        nested.decode(u32(MAX_EMPTY_ELEMENTS))


def test_the_class_of_a_part_of_a_message() -> None:
    codec = STORE.codec("geometry_msgs/Twist")
    assert isinstance(codec.message_class().linear, codec.class_of(codec.tree.members[0].node))  # type: ignore[arg-type]


def test_an_array_of_length_zero_has_no_bytes() -> None:
    codec = store_of(Kind="int8[0] x\nint8 y").codec("test/Kind")
    assert codec.encode({"x": [], "y": 7}) == b"\7"


class ArrayLike:
    """Converts to a list, but is not a Python sequence, like a numpy array."""

    def __array__(self) -> None: ...

    def __iter__(self) -> Iterator[int]:
        return iter((1, 2, 3))


def test_bytes_of_an_array() -> None:
    assert to_bytes(ArrayLike()) == b"\1\2\3"


def test_short_arrays_of_numbers_in_a_part() -> None:
    store = store_of(Part="float64[3] x\nint8[] y\nstring z", Kind="test/Part part\nstring name")
    codec = store.codec("test/Kind")
    sent = {"part": {"x": [1.0, 2.0, 3.0], "y": [4, 5], "z": "six"}, "name": "seven"}
    part = codec.decode(codec.encode(sent)).part
    assert (part.x, part.y, part.z) == ([1.0, 2.0, 3.0], [4, 5], "six")


def test_a_single_value_is_that_of_the_only_field() -> None:
    codec = STORE.codec("std_msgs/String")
    payload = b"\2\0\0\0hi"
    assert codec.encode_given("hi", {}) == payload
    assert codec.encode_given({"data": "hi"}, {}) == payload
    assert codec.encode_given(codec.message_class(data="hi"), {}) == payload
    with pytest.raises(SerializationError, match=r"has 2 fields \(linear, angular\), so give values by name"):
        STORE.codec("geometry_msgs/Twist").encode_given(1.0, {})


def test_a_message_as_a_dictionary() -> None:
    message = STORE.codec("tf2_msgs/TFMessage").conform({"transforms": [{"child_frame_id": "arm"}]})
    (transform,) = message.to_dict()["transforms"]
    assert transform["child_frame_id"] == "arm"
    assert transform["transform"]["translation"] == {"x": 0.0, "y": 0.0, "z": 0.0}


@pytest.mark.parametrize(
    ("field", "value", "stamp"),
    [
        ("time", "now", Time(7, 8)),
        ("time", 1.5, Time(1, 500_000_000)),
        ("duration", -1.5, Duration(-2, 500_000_000)),
        ("duration", 2, Duration(2, 0)),
    ],
)
def test_times_as_numbers_where_now_is_known(field: str, value: object, stamp: object) -> None:
    codec = store_of(Kind=f"{field} stamp").codec("test/Kind")
    sent = codec.encode({"stamp": value}, now=lambda: Time(7, 8))
    assert codec.decode(sent).stamp == stamp


@pytest.mark.parametrize("value", [-1.0, math.inf, True, "later"])
def test_values_that_are_no_time(value: object) -> None:
    codec = store_of(Kind="time stamp").codec("test/Kind")
    with pytest.raises(SerializationError, match="stamp"):
        codec.encode({"stamp": value}, now=lambda: Time(7, 8))


def test_a_message_is_given_whole_or_by_its_fields_or_as_its_only_value() -> None:
    codec = STORE.codec("std_msgs/Int16")
    given = [(None, {"data": 7}), (7, {}), ({"data": 7}, {}), (codec.message_class(data=7), {})]
    assert {codec.encode_given(message, fields) for message, fields in given} == {b"\7\0"}
    with pytest.raises(SerializationError, match="given both as a message and as fields"):
        codec.encode_given(7, {"data": 7})
