"""Links of a URDF: shapes, materials and masses. An invalid one is reported and omitted."""

from __future__ import annotations

import math
from typing import TypeAlias

from rostether.errors import RobotModelError
from rostether.mechanisms.xml_tree import XmlElement
from rostether.robot.robot_model import Inertial, Link, Shape
from rostether.robot.transform import Transform, Vector, quaternion_from_rpy

Color: TypeAlias = tuple[float, float, float, float]

_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def read_colors(robot: XmlElement, numbers: Numbers, problems: list[str]) -> dict[str, Color]:
    """Return the colors of the materials that a robot defines for all links."""
    colors = {}
    for material in robot.all("material"):
        try:
            color = _color(material, numbers)
        except RobotModelError as error:
            problems.append(str(error))
            continue
        if color is not None:
            colors[material.get("name") or ""] = color
    return colors


def read_link(element: XmlElement, numbers: Numbers, colors: dict[str, Color], problems: list[str]) -> Link:
    """Return one link; its errors are added to `problems`."""
    name = element.get("name") or ""
    if not name:
        problems.append(f"line {element.line}: a link has no name")
    shapes: dict[str, list[Shape]] = {"visual": [], "collision": []}
    for kind, found in shapes.items():
        for each in element.all(kind):
            try:
                found.append(_shape(each, numbers, colors, f"{kind} of link {name!r}"))
            except RobotModelError as error:
                problems.append(str(error))
    inertial = None
    described = element.first("inertial")
    if described is not None:
        try:
            inertial = _inertial(described, numbers, f"inertial of link {name!r}")
        except RobotModelError as error:
            problems.append(str(error))
    return Link(name, tuple(shapes["visual"]), tuple(shapes["collision"]), inertial)


def _shape(element: XmlElement, numbers: Numbers, colors: dict[str, Color], what: str) -> Shape:
    geometry = element.first("geometry")
    form = next(iter(geometry.children), None) if geometry is not None else None
    if form is None:
        raise RobotModelError(f"line {element.line}: {what} has no geometry")
    origin = numbers.origin(element, what)
    material = element.first("material")
    named = (material.get("name") or "") if material is not None else ""
    color = _color(material, numbers) if material is not None else None
    kind, size, mesh = _form(form, numbers, what)
    return Shape(kind, size, origin, mesh, named, color if color is not None else colors.get(named))


def _form(form: XmlElement, numbers: Numbers, what: str) -> tuple[str, tuple[float, ...], str]:
    match form.tag:
        case "box":
            return "box", numbers.vector(form, form.get("size") or "", f"the size of {what}"), ""
        case "cylinder":
            return (
                "cylinder",
                (numbers.needed(form, "radius", what), numbers.needed(form, "length", what)),
                "",
            )
        case "sphere":
            return "sphere", (numbers.needed(form, "radius", what),), ""
        case "mesh":
            mesh = form.get("filename")
            if not mesh:
                raise RobotModelError(f"line {form.line}: the mesh of {what} has no filename")
            return "mesh", numbers.vector(form, form.get("scale") or "1 1 1", f"the scale of {what}"), mesh
        case _:
            raise RobotModelError(
                f"line {form.line}: {what} is a <{form.tag}>; known: box, cylinder, sphere, mesh"
            )


def _color(material: XmlElement, numbers: Numbers) -> Color | None:
    color = material.first("color")
    if color is None:
        return None
    what = f"the rgba of material {material.get('name')!r}"
    red, green, blue, alpha = numbers.many(color, color.get("rgba") or "", what, 4)
    return red, green, blue, alpha


def _inertial(element: XmlElement, numbers: Numbers, what: str) -> Inertial:
    mass, inertia = element.first("mass"), element.first("inertia")
    if mass is None or inertia is None:
        raise RobotModelError(f"line {element.line}: {what} needs <mass> and <inertia>")
    ixx, ixy, ixz, iyy, iyz, izz = (numbers.needed(inertia, name, what) for name in _INERTIA)
    value = numbers.needed(mass, "value", what)
    return Inertial(value, numbers.origin(element, what), (ixx, ixy, ixz, iyy, iyz, izz))


class Numbers:
    """Reads the numbers of one file. Every method raises RobotModelError with file and line."""

    def __init__(self, file: str) -> None:
        self._file = file

    def attribute(self, element: XmlElement, name: str, what: str, default: float) -> float:
        """Return an attribute as a number."""
        text = element.get(name)
        return default if text is None else self._number(element, text, f"{name} of {what}")

    def needed(self, element: XmlElement, name: str, what: str) -> float:
        """Return a required attribute as a number."""
        text = element.get(name)
        if text is None:
            raise RobotModelError(f"{self._file}:{element.line}: {what} has no {name}")
        return self._number(element, text, f"{name} of {what}")

    def vector(self, element: XmlElement, text: str, what: str) -> Vector:
        """Return three numbers."""
        numbers = [self._number(element, word, what) for word in text.split()]
        if len(numbers) != 3:
            raise RobotModelError(
                f"{self._file}:{element.line}: {what} has {len(numbers)} numbers ({text!r}), not 3"
            )
        return numbers[0], numbers[1], numbers[2]

    def many(self, element: XmlElement, text: str, what: str, count: int) -> tuple[float, ...]:
        """Return `count` numbers."""
        numbers = tuple(self._number(element, word, what) for word in text.split())
        if len(numbers) != count:
            raise RobotModelError(
                f"{self._file}:{element.line}: {what} has {len(numbers)} numbers ({text!r}), not {count}"
            )
        return numbers

    def origin(self, element: XmlElement, what: str) -> Transform:
        """Return the transform of an element's <origin xyz rpy>; missing values are zero."""
        origin = element.first("origin")
        if origin is None:
            return Transform()
        xyz, rpy = origin.get("xyz"), origin.get("rpy")
        place = self.vector(origin, xyz, f"the origin of {what}") if xyz is not None else (0.0, 0.0, 0.0)
        turn = self.vector(origin, rpy, f"the rpy of {what}") if rpy is not None else (0.0, 0.0, 0.0)
        return Transform(place, quaternion_from_rpy(*turn)).normalized()

    def _number(self, element: XmlElement, text: str, what: str) -> float:
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            hint = "; expand this xacro first" if "${" in text else ""
            raise RobotModelError(f"{self._file}:{element.line}: {what} is {text!r}, not a number{hint}")
        return number
