"""The items of a picture: lines, areas and text, in pixels from the upper left corner.

The font is monospaced, so that the width of a text is known before it is drawn.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from enum import StrEnum
from typing import TypeAlias

from msgspec import Struct, field

Point: TypeAlias = tuple[float, float]
Color: TypeAlias = tuple[int, int, int]

WHITE: Color = (255, 255, 255)
# The width of a character in usual monospaced fonts, as a fraction of the font size.
ADVANCE = 0.6

# Enough that no corners are visible at the size of a label.
_ELLIPSE_POINTS = 64


class Anchor(StrEnum):
    """The part of a text that is at its position."""

    START = "start"
    MIDDLE = "middle"
    END = "end"


class Line(Struct, frozen=True):
    """A line through points; with `fill`, the line is closed and the convex area inside is painted."""

    points: tuple[Point, ...]
    color: Color
    width: float = 1.0
    fill: Color | None = None


class Text(Struct, frozen=True):
    """One line of text; `y` is its base line."""

    x: float
    y: float
    text: str
    size: float
    color: Color
    anchor: Anchor = Anchor.START


Item: TypeAlias = Line | Text


class Scene(Struct):
    """A picture; later items cover earlier ones."""

    width: int
    height: int
    background: Color = WHITE
    items: list[Item] = field(default_factory=list)

    def line(self, points: Iterable[Point], color: Color, width: float = 1.0) -> None:
        """Draw a line through points."""
        self.items.append(Line(tuple(points), color, width))

    def area(self, points: Iterable[Point], fill: Color, color: Color, width: float = 1.0) -> None:
        """Paint a convex area and draw its edge."""
        self.items.append(Line(tuple(points), color, width, fill))

    def text(
        self, x: float, y: float, text: str, size: float, color: Color, anchor: Anchor = Anchor.START
    ) -> None:
        """Write one line of text."""
        self.items.append(Text(x, y, text, size, color, anchor))


def text_width(text: str, size: float) -> float:
    """Return the width of a text in pixels."""
    return len(text) * size * ADVANCE


def rectangle(x: float, y: float, width: float, height: float) -> Sequence[Point]:
    """Return the corners of a rectangle, from the upper left."""
    return ((x, y), (x + width, y), (x + width, y + height), (x, y + height))


def ellipse(x: float, y: float, width: float, height: float) -> Sequence[Point]:
    """Return points on the ellipse with a center, width and height."""
    turns = [2 * math.pi * step / _ELLIPSE_POINTS for step in range(_ELLIPSE_POINTS)]
    return [(x + width / 2 * math.cos(turn), y + height / 2 * math.sin(turn)) for turn in turns]
