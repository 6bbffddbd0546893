"""Reads and creates point clouds, for the module sensor_msgs.point_cloud2."""

from __future__ import annotations

import struct
import sys
from collections import namedtuple
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from rostether.rospy.client.message import Message
from rostether.rospy.client.message_types import all_types

_PointCloud2: Any = all_types().message_class("sensor_msgs/PointCloud2")
_PointField: Any = all_types().message_class("sensor_msgs/PointField")

# The format characters of `struct` for PointField's types, and their sizes in bytes.
DATATYPES = {
    _PointField.INT8: ("b", 1),
    _PointField.UINT8: ("B", 1),
    _PointField.INT16: ("h", 2),
    _PointField.UINT16: ("H", 2),
    _PointField.INT32: ("i", 4),
    _PointField.UINT32: ("I", 4),
    _PointField.FLOAT32: ("f", 4),
    _PointField.FLOAT64: ("d", 8),
}


def read_points(
    cloud: Any,
    field_names: Iterable[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[tuple[int, int]] = (),
) -> Iterator[tuple[Any, ...]]:
    """Yield the points, or those at `uvs` (column, row), as tuples of the fields in their order in the data.

    Raises TypeError if the message is not a cloud, struct.error if the data is too short.
    """
    if not isinstance(cloud, Message) or cloud._type != _PointCloud2._type:
        raise TypeError("cloud is not a sensor_msgs.msg.PointCloud2")
    wanted = None if field_names is None else frozenset(field_names)
    layout = struct.Struct(struct_format(cloud.is_bigendian, cloud.fields, wanted))
    pixels = list(uvs)
    points = (
        (layout.unpack_from(cloud.data, cloud.row_step * v + cloud.point_step * u) for u, v in pixels)
        if pixels
        else _all_points(cloud, layout)
    )
    if not skip_nans:
        yield from points
        return
    for point in points:
        if all(value == value for value in point):  # only NaN differs from itself
            yield point


def read_points_list(
    cloud: Any,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[tuple[int, int]] = (),
) -> list[Any]:
    """Return the points as named tuples. Raises the same errors as `read_points`."""
    names = [field.name for field in cloud.fields] if field_names is None else list(field_names)
    point_class: Any = namedtuple("Point", names)  # type: ignore[misc]
    return [point_class._make(point) for point in read_points(cloud, names, skip_nans, uvs)]


def create_cloud(header: Any, fields: Sequence[Any], points: Iterable[Sequence[Any]]) -> Any:
    """Return a cloud of one row; each point has a value for each field.

    Raises struct.error for wrong values.
    """
    layout = struct.Struct(struct_format(False, fields))
    data = b"".join([layout.pack(*point) for point in points])
    return _PointCloud2(
        header=header,
        height=1,
        width=len(data) // layout.size if layout.size else 0,
        is_dense=False,
        is_bigendian=False,
        fields=fields,
        point_step=layout.size,
        row_step=len(data),
        data=data,
    )


def create_cloud_xyz32(header: Any, points: Iterable[Sequence[float]]) -> Any:
    """Return a point cloud with x, y and z. Raises struct.error for wrong values."""
    fields = [_PointField(name, 4 * index, _PointField.FLOAT32, 1) for index, name in enumerate("xyz")]
    return create_cloud(header, fields, points)


def struct_format(is_bigendian: bool, fields: Iterable[Any], field_names: Iterable[str] | None = None) -> str:
    """Return the format of `struct` for the wanted fields of a point, without the bytes between them."""
    text = ">" if is_bigendian else "<"
    end = 0
    for field in sorted(fields, key=lambda each: int(each.offset)):
        if field_names is not None and field.name not in field_names:
            continue
        if field.datatype not in DATATYPES:
            sys.stderr.write(f"Skipping unknown PointField datatype [{field.datatype}]\n")
            continue
        code, size_bytes = DATATYPES[field.datatype]
        text += "x" * max(field.offset - end, 0) + field.count * code
        end = max(field.offset, end) + field.count * size_bytes
    return text


def _all_points(cloud: Any, layout: struct.Struct) -> Iterator[tuple[Any, ...]]:
    for row in range(cloud.height):
        start = cloud.row_step * row
        if layout.size == cloud.point_step and layout.size:
            yield from layout.iter_unpack(memoryview(cloud.data)[start : start + layout.size * cloud.width])
        else:
            for column in range(cloud.width):
                yield layout.unpack_from(cloud.data, start + cloud.point_step * column)
