"""Converts a scene to SVG or PNG; the package `resvg_py` (extra `pictures`) draws the PNG."""

from __future__ import annotations

import re
from typing import Any
from xml.sax.saxutils import escape

from rostether.errors import ConfigError
from rostether.extras import install_command
from rostether.pictures.scene import Color, Line, Point, Scene, Text, text_width

# Larger pictures need hundreds of megabytes, and viewers cannot show them well.
MAX_PIXELS = 40_000_000

# Pixels per unit of the scene: sharp on high-resolution screens.
_SCALE = 2

_FACES = "DejaVu Sans Mono, Menlo, Consolas, monospace"
# XML 1.0 cannot contain these characters; names from peers may.
_FORBIDDEN = re.compile("[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\ud800-\\udfff\\ufffe\\uffff]")


def png(scene: Scene) -> bytes:
    """Return the picture as a PNG file with two pixels per unit of the scene, or one if it is large.

    Raises ConfigError if the picture is too large, resvg_py is not installed, or the system has no font.
    """
    area = scene.width * scene.height
    if area > MAX_PIXELS:
        raise ConfigError(
            f"a PNG of {scene.width} x {scene.height} pixels is too large; save as .svg, or show less of the"
            " graph"
        )
    scale = _SCALE if area * _SCALE**2 <= MAX_PIXELS else 1
    resvg = _resvg_package()
    _check_fonts(resvg)
    return bytes(resvg.svg_to_bytes(svg_string=svg(scene), zoom=scale))


def _resvg_package() -> Any:
    try:
        import resvg_py
    except ImportError:
        raise ConfigError(
            f"PNG support is not installed; run: {install_command('pictures')}; or save as .svg"
        ) from None
    return resvg_py


def _check_fonts(resvg: Any) -> None:
    # Without a font, resvg omits all text without an error.
    blank, letter = Scene(20, 20), Scene(20, 20)
    letter.text(2, 16, "M", 16, (0, 0, 0))
    if resvg.svg_to_bytes(svg_string=svg(blank)) == resvg.svg_to_bytes(svg_string=svg(letter)):
        raise ConfigError(
            "no font for the text of the picture is installed; install one, such as the package "
            "fonts-dejavu-core, or save as .svg"
        )


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
