# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import geometry_msgs
from rostether.serde.values import Message

class Mesh(Message):
    triangles: list[MeshTriangle]
    vertices: list[geometry_msgs.Point]
    def __init__(self, *, triangles: Sequence[MeshTriangle | Mapping[str, Any]] = ..., vertices: Sequence[geometry_msgs.Point | Mapping[str, Any]] = ...) -> None: ...

class MeshTriangle(Message):
    vertex_indices: list[int]
    def __init__(self, *, vertex_indices: Sequence[int] = ...) -> None: ...

class Plane(Message):
    coef: list[float]
    def __init__(self, *, coef: Sequence[float] = ...) -> None: ...

class SolidPrimitive(Message):
    BOX: int
    SPHERE: int
    CYLINDER: int
    CONE: int
    BOX_X: int
    BOX_Y: int
    BOX_Z: int
    SPHERE_RADIUS: int
    CYLINDER_HEIGHT: int
    CYLINDER_RADIUS: int
    CONE_HEIGHT: int
    CONE_RADIUS: int
    type: int
    dimensions: list[float]
    def __init__(self, *, type: int = ..., dimensions: Sequence[float] = ...) -> None: ...
