"""Messages as Python values: fields, zero values, equality, constants, odd names."""

from __future__ import annotations

import copy

import pytest

from rostether.errors import DefinitionError, SerializationError
from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import Field, FieldType, MessageSpec
from rostether.rostime import Duration, Time
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import TypeTrees
from rostether.serde.values import Message, MessageClasses
from unit.serde.definitions import store_of

STORE = TypeStore(Registry())


def message_class(name: str) -> type[Message]:
    return STORE.codec(name).message_class


def test_missing_fields_are_zero() -> None:
    message = (
        store_of(
            All="bool a\nint8 b\nfloat32 c\nstring d\ntime e\nduration f\nuint8[] g\nchar[2] h\nint32[] i\n"
            "float64[3] j\nstring[2] k\ntime[1] l\ngeometry_msgs/Point m\ngeometry_msgs/Point[2] n\n"
            "uint8[0] o"
        )
        .codec("test/All")
        .message_class()
    )
    point = message_class("geometry_msgs/Point")()
    expected = [False, 0, 0.0, "", Time(), Duration(), b"", b"\0\0", [], [0.0] * 3, ["", ""], [Time()]]
    expected += [point, [point, point], b""]
    assert [getattr(message, name) for name in "abcdefghijklmno"] == expected
    assert message.a is False
    assert message.n[0] is not message.n[1]


def test_zero_values_are_not_shared() -> None:
    imu = message_class("sensor_msgs/Imu")
    first = imu()
    first.orientation_covariance[0] = 1.0
    first.header.frame_id = "base"
    assert imu().orientation_covariance[0] == 0.0
    assert imu().header.frame_id == ""


def test_fields_by_keyword() -> None:
    vector = message_class("geometry_msgs/Vector3")(x=1.5, z=-2.0)
    assert (vector.x, vector.y, vector.z) == (1.5, 0.0, -2.0)
    with pytest.raises(SerializationError, match="geometry_msgs/Vector3 has no field 'w'; it has x, y, z"):
        message_class("geometry_msgs/Vector3")(w=1.0)
    with pytest.raises(SerializationError, match="std_msgs/Empty has no field 'x'; it has no fields"):
        message_class("std_msgs/Empty")(x=1)


def test_no_other_attributes() -> None:
    with pytest.raises(AttributeError):
        message_class("std_msgs/Bool")().dta = True


def test_equality() -> None:
    point, vector = message_class("geometry_msgs/Point"), message_class("geometry_msgs/Vector3")
    assert point(x=1.0) == point(x=1.0)
    assert point(x=1.0) != point(x=2.0)
    assert point() != vector()
    assert point() != {"x": 0.0, "y": 0.0, "z": 0.0}
    assert point(x=float("nan")) != point(x=float("nan"))
    other_store = TypeStore(Registry()).codec("geometry_msgs/Point").message_class
    assert point(x=1.0) == other_store(x=1.0)
    with pytest.raises(TypeError):
        hash(point())


def test_repr_shows_every_field() -> None:
    header = message_class("std_msgs/Header")(seq=1, stamp=Time(2, 3), frame_id="map")
    assert repr(header) == "std_msgs/Header(seq=1, stamp=Time(secs=2, nsecs=3), frame_id='map')"


def test_deep_copy() -> None:
    original = message_class("geometry_msgs/Twist")()
    duplicate = copy.deepcopy(original)
    duplicate.linear.x = 1.0
    assert original.linear.x == 0.0
    assert duplicate != original


def test_constants_are_on_the_class() -> None:
    assert getattr(message_class("rosgraph_msgs/Log"), "WARN") == 4  # noqa: B009
    clash = store_of(Clash="int32 X=1\nint32 mro=5\nint32 Y=2\nint32 Y").codec("test/Clash").message_class
    assert {"X": 1, "mro": 5}.items() <= vars(clash).items()
    assert clash().Y == 0


ODD_NAMES = [
    "from",
    "lambda",
    "pass",
    "self",
    "None",
    "True",
    "class",
    "print",
    "mro",
    "fields",
    "b",
    "o",
    "m",
    "v0",
]


def test_names_that_mean_something_to_python() -> None:
    text = "\n".join(f"int32 {name}" for name in ODD_NAMES)
    store = store_of(Odd=text, Outer="Odd import\nOdd[] if\nstring def")
    odd = store.codec("test/Odd")
    message = odd.message_class(**{name: place for place, name in enumerate(ODD_NAMES)})
    assert odd.decode(odd.encode(message)) == message
    assert odd.encode({"from": 7})[:4] == b"\7\0\0\0"
    outer = store.codec("test/Outer")
    nested = outer.message_class(**{"import": message, "if": [message, message], "def": "end"})
    again = outer.decode(outer.encode(nested))
    assert again == nested
    assert getattr(again, "import").self == ODD_NAMES.index("self")


@pytest.mark.parametrize("name", ["x = 1; import os", "a b", "__init__", "_x", "1x", "", "x\n", "größe"])
def test_names_that_are_none_never_reach_source(name: str) -> None:
    spec = MessageSpec("test", "Bad", (Field(FieldType("int32"), name),), (), "")

    class Source:
        def message(self, name: str) -> MessageSpec:
            return spec

    with pytest.raises(DefinitionError, match="names are letters"):
        MessageClasses().of(TypeTrees(Source()).struct("test/Bad"))


def test_field_twice() -> None:
    twice = Field(FieldType("int32"), "x")

    class Source:
        def message(self, name: str) -> MessageSpec:
            return MessageSpec("test", "Bad", (twice, twice), (), "")

    with pytest.raises(DefinitionError, match="two fields of the same name"):
        MessageClasses().of(TypeTrees(Source()).struct("test/Bad"))


def test_a_value_without_a_field_name_is_refused() -> None:
    with pytest.raises(TypeError, match=r"std_msgs/String takes its fields by name: String\(data=...\)"):
        message_class("std_msgs/String")("hello")
