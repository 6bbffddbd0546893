"""A scene as SVG: text stays text, which browsers find and scale."""

from __future__ import annotations

import re
from xml.sax.saxutils import escape

from rostether.pictures.scene import Color, Line, Point, Scene, Text, text_width

_FACES = "DejaVu Sans Mono, Menlo, Consolas, monospace"
# XML 1.0 cannot contain these; names from peers may.
_FORBIDDEN = re.compile("[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\ud800-\\udfff\\ufffe\\uffff]")


def svg(scene: Scene) -> str:
    """Return the picture as an SVG document."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{scene.width}" height="{scene.height}" '
        f'viewBox="0 0 {scene.width} {scene.height}" font-family="{_FACES}">',
        f'<rect width="100%" height="100%" fill="{_color(scene.background)}"/>',
    ]
    lines += [_line(each) if isinstance(each, Line) else _text(each) for each in scene.items]
    return "\n".join([*lines, "</svg>", ""])


def _line(line: Line) -> str:
    tag = "polyline" if line.fill is None else "polygon"
    fill = "none" if line.fill is None else _color(line.fill)
    points = " ".join(map(_point, line.points))
    return (
        f'<{tag} points="{points}" fill="{fill}" stroke="{_color(line.color)}" '
        f'stroke-width="{_number(line.width)}" stroke-linejoin="round" stroke-linecap="round"/>'
    )


def _text(text: Text) -> str:
    # The length is given, because a browser may have none of the fonts.
    shown = _FORBIDDEN.sub("\ufffd", text.text)
    return (
        f'<text x="{_number(text.x)}" y="{_number(text.y)}" font-size="{_number(text.size)}" '
        f'fill="{_color(text.color)}" text-anchor="{text.anchor}" lengthAdjust="spacingAndGlyphs" '
        f'textLength="{_number(text_width(text.text, text.size))}">{escape(shown)}</text>'
    )


def _point(point: Point) -> str:
    return f"{_number(point[0])},{_number(point[1])}"


def _number(value: float) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".")


def _color(color: Color) -> str:
    return "#{:02x}{:02x}{:02x}".format(*color)
