"""Checks of a URDF's shapes, materials and masses. The poses of links do not depend on these."""

from __future__ import annotations

import math

from rostether.errors import RobotModelError
from rostether.mechanisms.xml_tree import XmlElement
from rostether.robot.transform import Transform, Vector, quaternion_from_rpy

_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def check_materials(robot: XmlElement, numbers: Numbers, problems: list[str]) -> None:
    """Append the errors in the materials that a robot defines for all links."""
    for material in robot.all("material"):
        try:
            _check_color(material, numbers)
        except RobotModelError as error:
            problems.append(str(error))


def check_link(name: str, element: XmlElement, numbers: Numbers, problems: list[str]) -> None:
    """Append the errors in a link's name, shapes and masses."""
    if not name:
        problems.append(f"line {element.line}: a link has no name")
    checks = {"visual": _check_shape, "collision": _check_shape, "inertial": _check_inertial}
    for kind, check in checks.items():
        for each in element.all(kind):
            try:
                check(each, numbers, f"{kind} of link {name!r}")
            except RobotModelError as error:
                problems.append(str(error))


def _check_shape(element: XmlElement, numbers: Numbers, what: str) -> None:
    geometry = element.first("geometry")
    form = next(iter(geometry.children), None) if geometry is not None else None
    if form is None:
        raise RobotModelError(f"line {element.line}: {what} has no geometry")
    numbers.origin(element, what)
    material = element.first("material")
    if material is not None:
        _check_color(material, numbers)
    _check_form(form, numbers, what)


def _check_form(form: XmlElement, numbers: Numbers, what: str) -> None:
    match form.tag:
        case "box":
            numbers.vector(form, form.get("size") or "", f"the size of {what}")
        case "cylinder":
            numbers.needed(form, "radius", what)
            numbers.needed(form, "length", what)
        case "sphere":
            numbers.needed(form, "radius", what)
        case "mesh":
            if not form.get("filename"):
                raise RobotModelError(f"line {form.line}: the mesh of {what} has no filename")
            numbers.vector(form, form.get("scale") or "1 1 1", f"the scale of {what}")
        case _:
            raise RobotModelError(
                f"line {form.line}: {what} is a <{form.tag}>; known: box, cylinder, sphere, mesh"
            )


def _check_color(material: XmlElement, numbers: Numbers) -> None:
    color = material.first("color")
    if color is not None:
        what = f"the rgba of material {material.get('name')!r}"
        numbers.many(color, color.get("rgba") or "", what, 4)


def _check_inertial(element: XmlElement, numbers: Numbers, what: str) -> None:
    mass, inertia = element.first("mass"), element.first("inertia")
    if mass is None or inertia is None:
        raise RobotModelError(f"line {element.line}: {what} needs <mass> and <inertia>")
    for name in _INERTIA:
        numbers.needed(inertia, name, what)
    numbers.needed(mass, "value", what)
    numbers.origin(element, what)


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
