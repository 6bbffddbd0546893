"""Checks of a URDF's shapes, materials and masses. The poses of links do not depend on these."""

from __future__ import annotations

from rostether.errors import RobotModelError
from rostether.mechanisms.xml_tree import XmlElement
from rostether.robot.urdf_numbers import number, numbers, origin, vector

_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def check_materials(robot: XmlElement, problems: list[str]) -> None:
    """Append the errors in the materials that a robot defines for all links."""
    for material in robot.all("material"):
        try:
            _check_color(material)
        except RobotModelError as error:
            problems.append(str(error))


def check_link(name: str, element: XmlElement, problems: list[str]) -> None:
    """Append the errors in a link's name, shapes and masses."""
    if not name:
        problems.append(str(element.error("a link has no name")))
    checks = {"visual": _check_shape, "collision": _check_shape, "inertial": _check_inertial}
    for kind, check in checks.items():
        for each in element.all(kind):
            try:
                check(each, f"{kind} of link {name!r}")
            except RobotModelError as error:
                problems.append(str(error))


def _check_shape(element: XmlElement, what: str) -> None:
    geometry = element.first("geometry")
    form = next(iter(geometry.children), None) if geometry is not None else None
    if form is None:
        raise element.error(f"{what} has no geometry")
    origin(element, what)
    material = element.first("material")
    if material is not None:
        _check_color(material)
    _check_form(form, what)


def _check_form(form: XmlElement, what: str) -> None:
    match form.tag:
        case "box":
            vector(form, form.get("size") or "", f"the size of {what}")
        case "cylinder":
            number(form, "radius", what)
            number(form, "length", what)
        case "sphere":
            number(form, "radius", what)
        case "mesh":
            if not form.get("filename"):
                raise form.error(f"the mesh of {what} has no filename")
            vector(form, form.get("scale") or "1 1 1", f"the scale of {what}")
        case _:
            raise form.error(f"{what} is a <{form.tag}>; known: box, cylinder, sphere, mesh")


def _check_color(material: XmlElement) -> None:
    color = material.first("color")
    if color is not None:
        numbers(color, color.get("rgba") or "", f"the rgba of material {material.get('name')!r}", 4)


def _check_inertial(element: XmlElement, what: str) -> None:
    mass, inertia = element.first("mass"), element.first("inertia")
    if mass is None or inertia is None:
        raise element.error(f"{what} needs <mass> and <inertia>")
    for name in _INERTIA:
        number(inertia, name, what)
    number(mass, "value", what)
    origin(element, what)
