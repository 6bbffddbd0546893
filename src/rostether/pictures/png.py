"""A scene as PNG, drawn here: lines with smooth edges, convex areas, letters of strokes."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Sequence
from itertools import pairwise

from rostether.errors import ConfigError
from rostether.pictures.scene import Anchor, Color, Line, Point, Scene, Text, text_width
from rostether.pictures.stroke_font import strokes

MAX_PIXELS = 40_000_000
"""Larger pictures take minutes and hundreds of megabytes here, and no viewer shows them well."""

_SCALE = 2  # pixels a unit of the scene: sharp on screens of today
_STROKE_WIDTH = 0.09  # of a letter, in font sizes
_DOT_WIDTH = 1.7  # of a dot, in widths of a stroke
_LEAST_STROKE = 1.1  # pixels: thinner letters turn grey


def png(scene: Scene, scale: int = _SCALE) -> bytes:
    """Return the picture as a PNG file, `scale` pixels for each of the scene's, one where it is large.

    Raises ConfigError for a picture that would be too large even so.
    """
    if scene.width * scene.height * scale * scale > MAX_PIXELS:
        scale = 1
    canvas = _Canvas(scene.width * scale, scene.height * scale, scene.background)
    for item in scene.items:
        if isinstance(item, Line):
            _draw_line(canvas, item, scale)
        else:
            _draw_text(canvas, item, scale)
    return canvas.encode()


def _draw_line(canvas: _Canvas, line: Line, scale: int) -> None:
    points = [(x * scale, y * scale) for x, y in line.points]
    if line.fill is not None:
        canvas.fill(points, line.fill)
        points.append(points[0])
    canvas.stroke(points, line.color, line.width * scale)


def _draw_text(canvas: _Canvas, text: Text, scale: int) -> None:
    width = text_width(text.text, text.size)
    x = text.x - {Anchor.START: 0.0, Anchor.MIDDLE: width / 2, Anchor.END: width}[text.anchor]
    size = text.size * scale
    line_width = max(_LEAST_STROKE, size * _STROKE_WIDTH)
    for stroke in strokes(text.text, x * scale, text.y * scale, size):
        is_dot = stroke[0] == stroke[-1] and len(stroke) == 2
        canvas.stroke(stroke, text.color, line_width * (_DOT_WIDTH if is_dot else 1))


class _Canvas:
    """Pixels of three bytes, row by row."""

    def __init__(self, width: int, height: int, background: Color) -> None:
        if width * height > MAX_PIXELS:
            raise ConfigError(
                f"a PNG of {width} x {height} pixels is too large; save as .svg, or show less of the graph"
            )
        self._width = width
        self._height = height
        self._rows = [bytearray(bytes(background) * width) for _ in range(height)]

    def fill(self, points: Sequence[Point], color: Color) -> None:
        """Paint a convex area; what is painted between its edges is not smoothed."""
        edges = list(pairwise([*points, points[0]]))
        top = max(0, math.ceil(min(y for _, y in points) - 0.5))
        bottom = min(self._height - 1, math.floor(max(y for _, y in points) - 0.5))
        for row in range(top, bottom + 1):
            y = row + 0.5
            crossings = [
                x1 + (y - y1) * (x2 - x1) / (y2 - y1)
                for (x1, y1), (x2, y2) in edges
                if (y1 <= y) != (y2 <= y)
            ]
            if crossings:
                first = max(0, math.ceil(min(crossings) - 0.5))
                last = min(self._width - 1, math.floor(max(crossings) - 0.5))
                if last >= first:
                    self._rows[row][3 * first : 3 * last + 3] = bytes(color) * (last - first + 1)

    def stroke(self, points: Sequence[Point], color: Color, width: float) -> None:
        """Draw a line with round ends."""
        for (x1, y1), (x2, y2) in pairwise(points):
            self._segment(x1, y1, x2, y2, width / 2, color)

    def _segment(self, x1: float, y1: float, x2: float, y2: float, radius: float, color: Color) -> None:
        """Go along the longer direction, and across it as far as the line is wide."""
        dx, dy = x2 - x1, y2 - y1
        is_steep = abs(dy) > abs(dx)
        if is_steep:
            x1, y1, dx, dy = y1, x1, dy, dx
        if dx < 0:
            x1, y1, dx, dy = x1 + dx, y1 + dy, -dx, -dy
        length_squared = dx * dx + dy * dy
        slope = dy / dx if dx else 0.0
        across = (radius + 1) * math.hypot(1, slope)
        along_limit, across_limit = (self._height, self._width) if is_steep else (self._width, self._height)
        first = max(0, math.floor(x1 - radius - 1))
        last = min(along_limit - 1, math.ceil(x1 + dx + radius + 1))
        for along in range(first, last + 1):
            px = along + 0.5 - x1
            middle = y1 + slope * min(max(px, 0.0), dx)
            begin = max(0, math.floor(middle - across))
            end = min(across_limit - 1, math.ceil(middle + across))
            for side in range(begin, end + 1):
                py = side + 0.5 - y1
                part = (px * dx + py * dy) / length_squared if length_squared else 0.0
                part = min(max(part, 0.0), 1.0)
                cover = radius + 0.5 - math.hypot(px - part * dx, py - part * dy)
                if cover > 0:
                    x, y = (side, along) if is_steep else (along, side)
                    self._blend(x, y, color, min(cover, 1.0))

    def _blend(self, x: int, y: int, color: Color, cover: float) -> None:
        row, at = self._rows[y], 3 * x
        for channel in range(3):
            below = row[at + channel]
            row[at + channel] = round(below + (color[channel] - below) * cover)

    def encode(self) -> bytes:
        """Return the PNG file. Source: W3C PNG, third edition; 8 bits a channel, no filter."""
        header = struct.pack(">IIBBBBB", self._width, self._height, 8, 2, 0, 0, 0)
        data = zlib.compress(b"".join(b"\0" + row for row in self._rows), 6)
        chunks = ((b"IHDR", header), (b"IDAT", data), (b"IEND", b""))
        return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, content) for kind, content in chunks)


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
