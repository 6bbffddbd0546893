"""The numbers in a URDF. Every function raises RobotModelError with file and line."""

from __future__ import annotations

import math

from rostether.mechanisms.xml_tree import XmlElement
from rostether.robot.transform import Transform, Vector, quaternion_from_rpy


def number(element: XmlElement, name: str, what: str, default: float | None = None) -> float:
    """Return an attribute as a number; without a default, the attribute is required."""
    text = element.get(name)
    if text is not None:
        return _number(element, text, f"{name} of {what}")
    if default is None:
        raise element.error(f"{what} has no {name}; add it")
    return default


def numbers(element: XmlElement, text: str, what: str, count: int) -> list[float]:
    """Return the `count` numbers in a text."""
    found = [_number(element, word, what) for word in text.split()]
    if len(found) != count:
        raise element.error(f"{what} has {len(found)} numbers ({text!r}), not {count}")
    return found


def vector(element: XmlElement, text: str, what: str) -> Vector:
    """Return the three numbers in a text."""
    x, y, z = numbers(element, text, what, 3)
    return x, y, z


def origin(element: XmlElement, what: str) -> Transform:
    """Return the transform in the <origin xyz rpy> of an element; missing values are zero."""
    found = element.first("origin")
    if found is None:
        return Transform()
    translation = vector(found, found.attributes.get("xyz", "0 0 0"), f"the origin of {what}")
    rpy = vector(found, found.attributes.get("rpy", "0 0 0"), f"the rpy of {what}")
    return Transform(translation, quaternion_from_rpy(*rpy)).normalized()


def _number(element: XmlElement, text: str, what: str) -> float:
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        hint = "; expand this xacro first" if "${" in text else ""
        raise element.error(f"{what} is {text!r}, not a number{hint}")
    return found
