"""Pictures are read back with Pillow to check their size and colors."""

from __future__ import annotations

import io
import sys
import xml.etree.ElementTree as ET

import pytest
import resvg_py
from PIL import Image

from rostether.errors import ConfigError
from rostether.pictures.png import png, svg
from rostether.pictures.scene import WHITE, Anchor, Color, Scene, rectangle

RED: Color = (255, 0, 0)
BLUE: Color = (0, 0, 255)


SVG = "{http://www.w3.org/2000/svg}"
BLACK = (0, 0, 0)


def drawn(scene: Scene) -> Image.Image:
    return Image.open(io.BytesIO(png(scene))).convert("RGB")


@pytest.mark.font
def test_a_picture_has_its_size_and_background() -> None:
    picture = drawn(Scene(4, 3, RED))
    assert picture.size == (8, 6)
    assert picture.getcolors() == [(48, RED)]


@pytest.mark.font
def test_lines_and_areas_are_at_their_places() -> None:
    scene = Scene(40, 30)
    scene.area(rectangle(5, 5, 30, 20), RED, BLUE, 2)
    scene.line([(0, 28), (40, 28)], BLUE, 2)
    picture = drawn(scene).reduce(2)
    assert picture.getpixel((20, 15)) == RED
    assert picture.getpixel((20, 5)) == picture.getpixel((20, 28)) == BLUE
    assert picture.getpixel((2, 2)) == WHITE


@pytest.mark.font
@pytest.mark.parametrize(("anchor", "left"), [(Anchor.START, 50), (Anchor.MIDDLE, 32), (Anchor.END, 14)])
def test_text_is_at_its_anchor(anchor: Anchor, left: int) -> None:
    scene = Scene(100, 20)
    scene.text(50, 15, "mmmmmm", 10, RED, anchor)
    gray = drawn(scene).reduce(2).convert("L").point(lambda value: 255 if value < 250 else 0)
    box = gray.getbbox()
    assert box is not None
    assert left - 1 <= box[0] < left + 3
    assert left + 32 < box[2] <= left + 37


def test_too_large_a_picture_is_rejected() -> None:
    with pytest.raises(ConfigError, match="too large"):
        png(Scene(20_000, 20_000))


def test_without_the_package_the_error_names_the_package_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "resvg_py", None)
    with pytest.raises(
        ConfigError, match=r"PNG support is not installed; run: .*rostether\[pictures\].*; or save as .svg"
    ):
        png(Scene(4, 3))


def test_without_a_font_no_picture_lacks_its_text(monkeypatch: pytest.MonkeyPatch) -> None:
    draw = resvg_py.svg_to_bytes

    def draw_without_fonts(**options: object) -> bytes:
        return draw(**options, skip_system_fonts=True)  # type: ignore[arg-type]

    monkeypatch.setattr(resvg_py, "svg_to_bytes", draw_without_fonts)
    with pytest.raises(ConfigError, match="no font for the text of the picture is installed"):
        png(Scene(4, 3))


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


def test_names_are_escaped() -> None:
    scene = Scene(10, 10)
    name = '</text><script>"&\x00\x1b\udc80'
    scene.text(0, 0, name, 10, BLACK)
    root = ET.fromstring(svg(scene).encode())
    assert [each.tag for each in root] == [f"{SVG}rect", f"{SVG}text"]
    assert root[1].text == '</text><script>"&\ufffd\ufffd\ufffd'
