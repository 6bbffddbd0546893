from __future__ import annotations

import xml.etree.ElementTree as ET

from rostether.pictures.scene import Anchor, Scene, rectangle
from rostether.pictures.svg import svg

SVG = "{http://www.w3.org/2000/svg}"
BLACK = (0, 0, 0)


def test_items_become_elements_in_their_order() -> None:
    scene = Scene(100, 50, (1, 2, 3))
    scene.line([(0, 0), (10.125, 20)], (255, 0, 16), 1.5)
    scene.area(rectangle(5, 5, 30, 20), (0, 128, 0), BLACK)
    scene.text(50, 25, "here", 10, BLACK, Anchor.MIDDLE)
    root = ET.fromstring(svg(scene).encode())
    background, line, area, text = root
    assert (root.get("width"), root.get("height")) == ("100", "50")
    assert background.get("fill") == "#010203"
    assert (line.tag, line.get("points")) == (f"{SVG}polyline", "0,0 10.12,20")
    assert (line.get("stroke"), line.get("stroke-width"), line.get("fill")) == ("#ff0010", "1.5", "none")
    assert (area.tag, area.get("fill")) == (f"{SVG}polygon", "#008000")
    assert (text.text, text.get("text-anchor"), text.get("textLength")) == ("here", "middle", "24")


def test_names_cannot_break_out() -> None:
    scene = Scene(10, 10)
    name = '</text><script>"&\x00\x1b\udc80'
    scene.text(0, 0, name, 10, BLACK)
    root = ET.fromstring(svg(scene).encode())
    assert [each.tag for each in root] == [f"{SVG}rect", f"{SVG}text"]
    assert root[1].text == '</text><script>"&\ufffd\ufffd\ufffd'
