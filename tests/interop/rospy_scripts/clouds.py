"""Uses point clouds without a graph, and prints the results."""

import math

import sensor_msgs.point_cloud2 as pc2
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

print(pc2.PointField is PointField, pc2.PointCloud2 is PointCloud2)
header = Header(frame_id="camera")
cloud = pc2.create_cloud_xyz32(header, [(1, 2, 3), [math.nan, 5, 6], (7.5, 8, 9)])
print(cloud)
print(list(pc2.read_points(cloud)))
print(list(pc2.read_points(cloud, skip_nans=True)), len(list(pc2.read_points(cloud, ("y",)))))
print(list(pc2.read_points(cloud, field_names=("z", "x"), uvs=[(2, 0), (0, 0)])))
print(list(pc2.read_points(cloud, skip_nans=True, uvs=[(1, 0), (0, 0)])))
print(point_cloud2.read_points_list(cloud, skip_nans=True)[1].z, pc2.read_points_list(cloud, ["y"])[0])
fields = [
    PointField("x", 0, PointField.FLOAT32, 1),
    PointField("intensity", 8, PointField.UINT16, 1),
    PointField("pair", 10, PointField.INT8, 2),
    PointField("t", 16, PointField.FLOAT64, 1),
]
mixed = pc2.create_cloud(header, fields, [(1, 2, 3, -4, 5), (0.5, 65535, -1, 1, 1e9)])
print(mixed.point_step, mixed.row_step, mixed.width, bytes(mixed.data).hex(), mixed.is_dense)
print(list(pc2.read_points(mixed)), list(pc2.read_points(mixed, field_names=["t", "pair"])))
rows = PointCloud2(
    height=2,
    width=2,
    fields=[PointField("a", 2, PointField.UINT16, 1)],
    is_bigendian=True,
    point_step=4,
    row_step=9,
    data=bytes(range(18)),
)
print(list(pc2.read_points(rows)))
for wrong in ("text", header):
    try:
        print(list(pc2.read_points(wrong)))
    except (AssertionError, TypeError) as error:
        print(error)
