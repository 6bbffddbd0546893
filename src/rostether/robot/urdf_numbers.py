"""Reads numbers in URDF attributes; errors contain the line."""

from __future__ import annotations

import math

from rostether.errors import RobotModelError
from rostether.mechanisms.xml_tree import XmlElement
from rostether.robot.transform import Transform, Vector, quaternion_from_rpy


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
