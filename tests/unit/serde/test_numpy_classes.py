from __future__ import annotations

import sys

import numpy
import pytest

from rostether.errors import ConfigError, SerializationError
from rostether.msgdef.registry import Registry
from rostether.serde.numpy_classes import NumpyClasses
from rostether.serde.store import TypeStore

REGISTRY = Registry()
PLAIN = TypeStore(REGISTRY)
NUMPY = TypeStore(REGISTRY, NumpyClasses())


@pytest.mark.parametrize(
    ("type_name", "field", "values", "dtype"),
    [
        ("sensor_msgs/LaserScan", "ranges", [1.5, 2.0], "float32"),
        ("sensor_msgs/LaserScan", "ranges", [], "float32"),
        ("sensor_msgs/Image", "data", b"\x00\xff", "uint8"),
        ("sensor_msgs/Image", "data", b"", "uint8"),
        ("sensor_msgs/Imu", "orientation_covariance", [float(n) for n in range(9)], "float64"),
        ("sensor_msgs/CameraInfo", "K", [float(n) for n in range(9)], "float64"),
        ("std_msgs/Int8MultiArray", "data", [-1, 1], "int8"),
        ("std_msgs/UInt64MultiArray", "data", [2**64 - 1], "uint64"),
    ],
)
def test_arrays_of_numbers_are_numpy_arrays(type_name: str, field: str, values: object, dtype: str) -> None:
    payload = PLAIN.codec(type_name).encode({field: values})
    message = NUMPY.codec(type_name).decode(payload)
    array = getattr(message, field)
    assert isinstance(array, numpy.ndarray)
    assert array.dtype == dtype
    assert not array.flags.writeable
    assert message.to_dict() == PLAIN.codec(type_name).decode(payload).to_dict()
    assert NUMPY.codec(type_name).encode(message) == payload
    assert message == NUMPY.codec(type_name).decode(payload)


def test_other_arrays_stay_lists() -> None:
    payload = PLAIN.codec("sensor_msgs/JointState").encode({"name": ["arm"], "position": [0.5]})
    message = NUMPY.codec("sensor_msgs/JointState").decode(payload)
    assert message.name == ["arm"]
    assert message.position.tolist() == [0.5]


def test_messages_are_compared_by_their_values() -> None:
    codec = NUMPY.codec("std_msgs/Float64MultiArray")
    assert codec.decode(codec.encode({"data": [1.0]})) != codec.decode(codec.encode({"data": [2.0]}))
    assert codec.decode(codec.encode({"data": [1.0]})) != "text"


def test_lengths_that_the_payload_does_not_have_are_refused() -> None:
    codec = NUMPY.codec("std_msgs/Float64MultiArray")
    payload = codec.encode({"data": [1.0, 2.0]})
    for cut in range(len(payload)):
        with pytest.raises(SerializationError):
            codec.decode(payload[:cut])


@pytest.mark.parametrize(("store", "kind"), [(NUMPY, numpy.ndarray), (PLAIN, list)])
def test_a_store_for_other_types_has_values_of_the_same_kind(store: TypeStore, kind: type) -> None:
    codec = store.for_registry(Registry()).codec("std_msgs/Int8MultiArray")
    assert isinstance(codec.decode(codec.encode({})).data, kind)


def test_without_numpy_the_error_names_the_package_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numpy", None)
    with pytest.raises(ConfigError, match="run: pip install numpy"):
        NumpyClasses()


def test_a_picture_is_encoded_row_by_row() -> None:
    picture = numpy.arange(12, dtype=numpy.uint8).reshape(2, 2, 3)
    codec = PLAIN.codec("sensor_msgs/Image")
    assert codec.decode(codec.encode({"data": picture})).data == bytes(range(12))
    with pytest.raises(SerializationError, match="'data' of sensor_msgs/Image needs bytes"):
        codec.encode({"data": picture.astype(numpy.float32)})


def test_an_error_shows_a_picture_of_another_type_on_one_line() -> None:
    image = PLAIN.codec("sensor_msgs/Image")
    with pytest.raises(SerializationError, match=r"'data' of sensor_msgs/Image .*got array\(\[\[0") as raised:
        image.encode({"data": numpy.zeros((3, 4), numpy.float32)})
    assert "\n" not in str(raised.value)
