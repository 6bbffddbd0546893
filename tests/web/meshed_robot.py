"""A package with a robot that has meshes: STL in millimeters, Collada with a color, OBJ."""

from __future__ import annotations

import struct
from pathlib import Path

PACKAGE = "meshed_robot"

URDF = f"""<?xml version="1.0"?>
<robot name="{PACKAGE}">
  <material name="green"><color rgba="0 0.8 0 1" /></material>
  <link name="base_link">
    <visual>
      <origin xyz="0 0 0.06" />
      <geometry><mesh filename="package://{PACKAGE}/meshes/base.stl" scale="0.001 0.001 0.001" /></geometry>
      <material name="gray"><color rgba="0.6 0.6 0.65 1" /></material>
    </visual>
  </link>
  <link name="wheel">
    <visual><geometry><mesh filename="package://{PACKAGE}/meshes/wheel.dae" /></geometry></visual>
  </link>
  <joint name="wheel_joint" type="revolute">
    <parent link="base_link" /><child link="wheel" />
    <origin xyz="0 -0.11 0.04" /><axis xyz="0 1 0" />
    <limit lower="-3.14" upper="3.14" effort="1" velocity="6" />
  </joint>
  <link name="lidar">
    <visual>
      <geometry><mesh filename="package://{PACKAGE}/meshes/lidar.obj" /></geometry>
      <material name="green" />
    </visual>
  </link>
  <joint name="lidar_joint" type="fixed">
    <parent link="base_link" /><child link="lidar" /><origin xyz="0 0 0.12" />
  </joint>
</robot>
"""

LAUNCH = f"""<launch>
  <param name="robot_description" textfile="$(find {PACKAGE})/robot.urdf" />
  <node name="robot_state_publisher" pkg="robot_state_publisher" type="robot_state_publisher" />
  <node name="joint_state_publisher_gui" pkg="joint_state_publisher_gui" type="joint_state_publisher_gui" />
</launch>
"""

MANIFEST = f"""<package format="2">
  <name>{PACKAGE}</name><version>0.1.0</version><description>A robot with meshes.</description>
  <maintainer email="robot@example.org">Robot</maintainer><license>Apache-2.0</license>
</package>
"""

_CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
_TRIANGLES = [each for a, b, c, d in _FACES for each in ((a, b, c), (a, c, d))]


def write_robot(folder: Path) -> Path:
    """Write the package into a folder, and return its launch file."""
    package = folder / PACKAGE
    (package / "meshes").mkdir(parents=True)
    (package / "package.xml").write_text(MANIFEST)
    (package / "robot.urdf").write_text(URDF)
    (package / "meshes/base.stl").write_bytes(_stl(100, 80, 50))
    (package / "meshes/wheel.dae").write_text(_collada(0.04, 0.015, 0.04))
    (package / "meshes/lidar.obj").write_text(_obj(0.04, 0.04, 0.03))
    launch = package / "robot.launch"
    launch.write_text(LAUNCH)
    return launch


def _corners(x: float, y: float, z: float) -> list[tuple[float, float, float]]:
    return [(a * x, b * y, c * z) for a, b, c in _CORNERS]


def _stl(x: float, y: float, z: float) -> bytes:
    corners = _corners(x, y, z)
    facets = [
        struct.pack("<12fH", 0, 0, 0, *(value for corner in each for value in corners[corner]), 0)
        for each in _TRIANGLES
    ]
    return b"box".ljust(80) + struct.pack("<I", len(facets)) + b"".join(facets)


def _obj(x: float, y: float, z: float) -> str:
    vertices = [f"v {a} {b} {c}" for a, b, c in _corners(x, y, z)]
    faces = [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in _TRIANGLES]
    return "\n".join([*vertices, *faces]) + "\n"


def _collada(x: float, y: float, z: float) -> str:
    """Return a box in centimeters, with a color."""
    positions = " ".join(f"{value * 100:g}" for corner in _corners(x, y, z) for value in corner)
    indices = " ".join(str(corner) for each in _TRIANGLES for corner in each)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="centimeter" meter="0.01" /><up_axis>Z_UP</up_axis></asset>
  <library_effects><effect id="red"><profile_COMMON><technique sid="common"><lambert>
    <diffuse><color>0.9 0 0 1</color></diffuse>
  </lambert></technique></profile_COMMON></effect></library_effects>
  <library_materials><material id="paint"><instance_effect url="#red" /></material></library_materials>
  <library_geometries><geometry id="box"><mesh>
    <source id="p"><float_array id="pa" count="24">{positions}</float_array><technique_common>
      <accessor source="#pa" count="8" stride="3">
        <param name="X" type="float" /><param name="Y" type="float" /><param name="Z" type="float" />
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p" /></vertices>
    <triangles count="12" material="m">
      <input semantic="VERTEX" source="#v" offset="0" /><p>{indices}</p>
    </triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#box"><bind_material>
    <technique_common><instance_material symbol="m" target="#paint" /></technique_common>
  </bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#s" /></scene>
</COLLADA>
"""
