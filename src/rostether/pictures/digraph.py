"""A directed graph of boxes and ellipses: as text for Graphviz, and laid out as a scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum
from itertools import pairwise
from typing import TypeAlias

from msgspec import Struct

from rostether.mechanisms.text import escape_text
from rostether.pictures.layered_layout import Size, lay_out
from rostether.pictures.scene import Anchor, Color, Point, Scene, ellipse, rectangle, text_width

_SIZE = 12.0
_MARGIN = 16.0

# The padding of a label: on each side, and above and below together.
_PADDING = (14.0, 16.0)

# An ellipse is wider than a box around the same text by this factor.
_ELLIPSE_ROOM = 1.25
_ARROW_LENGTH = 8.0
_ARROW_HALF_WIDTH = 3.5
_LABEL_SIZE = 10.0

# The gap between a label and the line that it interrupts.
_LABEL_GAP = 4.0
# The gap between columns. With labels there are twice as many columns.
_GAP = 60.0
_LABELLED_GAP = 28.0
_CURVE_STEPS = 14

_INK: Color = (40, 44, 52)
_EDGE: Color = (110, 118, 130)
_LABEL: Color = (70, 80, 100)


class Shape(StrEnum):
    """The shape of a vertex, with its name in Graphviz."""

    ELLIPSE = "ellipse"
    BOX = "box"


_FILLS: dict[Shape, tuple[Color, Color]] = {
    Shape.ELLIPSE: ((221, 233, 252), (62, 104, 170)),
    Shape.BOX: ((246, 240, 222), (160, 132, 60)),
}


class Vertex(Struct, frozen=True):
    """A vertex; `key` is unique in its graph."""

    key: str
    label: str
    shape: Shape


class Edge(Struct, frozen=True):
    """An arrow between two vertices, by their keys."""

    source: str
    target: str
    label: str = ""


class Digraph(Struct, frozen=True):
    """Vertices and the edges between them, in the order of the output."""

    vertices: Sequence[Vertex]
    edges: Sequence[Edge]


_Line: TypeAlias = tuple[str, str, bool]  # source, target, whether it ends in an arrow


def dot(graph: Digraph) -> str:
    """Return the graph in Graphviz's language."""
    lines = ["digraph graph_of_nodes {", "  rankdir=LR;", '  node [fontname="DejaVu Sans Mono"];']
    lines += [
        f"  {quoted(each.key)} [label={quoted(each.label)}, shape={each.shape}];" for each in graph.vertices
    ]
    for edge in graph.edges:
        label = f" [label={quoted(edge.label)}]" if edge.label else ""
        lines.append(f"  {quoted(edge.source)} -> {quoted(edge.target)}{label};")
    return "\n".join([*lines, "}", ""])


def quoted(text: str) -> str:
    """Return a text as a string of Graphviz's language, on one line and without control characters."""
    return '"' + escape_text(text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")) + '"'


def draw(graph: Digraph) -> Scene:
    """Draw the graph from left to right. Raises ConfigError if it is too large."""
    sizes = {vertex.key: _size(vertex) for vertex in graph.vertices}
    lines: list[_Line] = []
    labels: dict[str, str] = {}
    for edge in dict.fromkeys(graph.edges):
        if edge.label:
            # The layout treats a label as a vertex in the middle of its edge.
            key = f"\0label {len(labels)}"
            labels[key] = edge.label
            sizes[key] = (text_width(edge.label, _LABEL_SIZE) + 2 * _LABEL_GAP, _LABEL_SIZE + 2)
            lines += [(edge.source, key, False), (key, edge.target, True)]
        elif edge.source != edge.target:
            lines.append((edge.source, edge.target, True))
    layout = lay_out(sizes, [line[:2] for line in lines], column_gap=_LABELLED_GAP if labels else _GAP)
    scene = Scene(math.ceil(layout.width + 2 * _MARGIN), math.ceil(layout.height + 2 * _MARGIN))
    for source, target, has_head in lines:
        _draw_edge(scene, layout.routes[source, target], has_head=has_head)
    for vertex in graph.vertices:
        _draw_vertex(scene, vertex, _moved(layout.positions[vertex.key]))
    for key, label in labels.items():
        x, y = _moved(layout.positions[key])
        scene.text(x, y + _LABEL_SIZE * 0.3, label, _LABEL_SIZE, _LABEL, Anchor.MIDDLE)
    return scene


def _size(vertex: Vertex) -> Size:
    room = _ELLIPSE_ROOM if vertex.shape is Shape.ELLIPSE else 1.0
    return (text_width(vertex.label, _SIZE) + 2 * _PADDING[0]) * room, _SIZE + _PADDING[1] * room


def _draw_vertex(scene: Scene, vertex: Vertex, position: Point) -> None:
    (x, y), (width, height) = position, _size(vertex)
    fill, color = _FILLS[vertex.shape]
    if vertex.shape is Shape.ELLIPSE:
        scene.area(ellipse(x, y, width, height), fill, color, 1.2)
    else:
        scene.area(rectangle(x - width / 2, y - height / 2, width, height), fill, color, 1.2)
    scene.text(x, y + _SIZE * 0.3, vertex.label, _SIZE, _INK, Anchor.MIDDLE)


def _draw_edge(scene: Scene, route: Sequence[Point], *, has_head: bool) -> None:
    points = _curve([_moved(point) for point in route])
    if not has_head:
        scene.line(points, _EDGE, 1.2)
        return
    tip, towards = points[-1], points[-2]
    angle = math.atan2(tip[1] - towards[1], tip[0] - towards[0])
    base = (tip[0] - _ARROW_LENGTH * math.cos(angle), tip[1] - _ARROW_LENGTH * math.sin(angle))
    scene.line([*points[:-1], base], _EDGE, 1.2)
    aside = (_ARROW_HALF_WIDTH * math.sin(angle), -_ARROW_HALF_WIDTH * math.cos(angle))
    corners = ((base[0] + aside[0], base[1] + aside[1]), (base[0] - aside[0], base[1] - aside[1]))
    scene.area([tip, *corners], _EDGE, _EDGE, 0.8)


def _curve(route: Sequence[Point]) -> list[Point]:
    """Return a smooth line through the points of a route; it is horizontal at each point."""
    points = [route[0]]
    for (x1, y1), (x2, y2) in pairwise(route):
        if y1 == y2:
            points.append((x2, y2))
            continue
        for step in range(1, _CURVE_STEPS + 1):
            part = step / _CURVE_STEPS
            # A cubic Bezier curve whose control points are at half the width.
            x = x1 + (x2 - x1) * (1.5 * part * (1 - part) + part**3)
            points.append((x, y1 + (y2 - y1) * part * part * (3 - 2 * part)))
    return points


def _moved(point: Point) -> Point:
    return point[0] + _MARGIN, point[1] + _MARGIN
