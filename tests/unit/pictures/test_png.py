"""Pictures are read back by a decoder of the test's own: size, and colors at places."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass

import pytest

from rostether.errors import ConfigError
from rostether.pictures.png import png
from rostether.pictures.scene import WHITE, Anchor, Color, Scene, ellipse, rectangle

RED: Color = (255, 0, 0)
BLUE: Color = (0, 0, 255)


@dataclass(frozen=True)
class Pixels:
    width: int
    height: int
    data: bytes

    def at(self, x: int, y: int) -> Color:
        place = y * (1 + 3 * self.width) + 1 + 3 * x
        red, green, blue = self.data[place : place + 3]
        return red, green, blue

    def touched(self, x: int, y: int, width: int, height: int) -> int:
        return sum(self.at(x + dx, y + dy) != WHITE for dx in range(width) for dy in range(height))


def decode(data: bytes) -> Pixels:
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    place, chunks = 8, {}
    while place < len(data):
        length, kind = struct.unpack_from(">I4s", data, place)
        content = data[place + 8 : place + 8 + length]
        (check,) = struct.unpack_from(">I", data, place + 8 + length)
        assert check == zlib.crc32(kind + content)
        chunks[kind] = content
        place += 12 + length
    width, height, *kind_of = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    assert kind_of == [8, 2, 0, 0, 0]
    pixels = Pixels(width, height, zlib.decompress(chunks[b"IDAT"]))
    assert len(pixels.data) == height * (1 + 3 * width)
    return pixels


def drawn(scene: Scene, scale: int = 1) -> Pixels:
    return decode(png(scene, scale))


def test_an_empty_scene_is_its_background() -> None:
    pixels = drawn(Scene(4, 3, RED), 2)
    assert (pixels.width, pixels.height) == (8, 6)
    assert {pixels.at(x, y) for x in range(8) for y in range(6)} == {RED}


@pytest.mark.parametrize(
    ("ends", "on", "off"),
    [
        (((2, 10), (17, 10)), (9, 10), (9, 14)),
        (((10, 2), (10, 17)), (10, 9), (14, 9)),
        (((17, 17), (2, 2)), (9, 9), (14, 4)),
        (((2, 17), (17, 2)), (10, 9), (4, 4)),
    ],
)
def test_a_line_is_where_it_should_be(
    ends: tuple[tuple[int, int], tuple[int, int]], on: tuple[int, int], off: tuple[int, int]
) -> None:
    scene = Scene(20, 20)
    scene.line(ends, RED, 3)
    pixels = drawn(scene)
    assert pixels.at(*on) == RED
    assert pixels.at(*off) == WHITE
    assert pixels.at(0, 0) == pixels.at(19, 19) == WHITE


def test_an_area_is_filled_and_edged() -> None:
    scene = Scene(40, 30)
    scene.area(rectangle(5, 5, 30, 20), RED, BLUE, 2)
    pixels = drawn(scene)
    assert pixels.at(20, 15) == RED
    assert pixels.at(20, 5) == BLUE
    assert pixels.at(2, 2) == WHITE


def test_an_ellipse_has_no_corners() -> None:
    scene = Scene(40, 30)
    scene.area(ellipse(20, 15, 36, 26), RED, RED)
    pixels = drawn(scene)
    assert pixels.at(20, 15) == RED
    assert pixels.at(4, 4) == WHITE
    assert pixels.at(4, 15) == RED


def test_what_is_outside_does_no_harm() -> None:
    scene = Scene(10, 10)
    scene.line([(-50, -50), (60, 60)], RED, 2)
    scene.area(rectangle(-5, -5, 100, 8), BLUE, BLUE)
    scene.text(-60, 5, "left of it", 8, RED)
    pixels = drawn(scene)
    assert pixels.at(8, 8) == RED
    assert pixels.at(5, 1) == BLUE


@pytest.mark.parametrize(("anchor", "left"), [(Anchor.START, 50), (Anchor.MIDDLE, 32), (Anchor.END, 14)])
def test_text_stands_at_its_anchor(anchor: Anchor, left: int) -> None:
    scene = Scene(100, 20)
    scene.text(50, 15, "mmmmmm", 10, RED, anchor)
    pixels = drawn(scene)
    assert pixels.touched(left, 5, 36, 12) > 40
    assert pixels.touched(0, 0, 100, 20) == pixels.touched(left, 5, 36, 12)


def test_all_printable_characters_differ() -> None:
    pictures = set()
    for code in range(33, 127):
        scene = Scene(12, 20)
        scene.text(0, 14, chr(code), 16, RED)
        pictures.add(drawn(scene, 2).data)
    assert len(pictures) == 94


def test_unknown_characters_are_boxes() -> None:
    pictures = set()
    for character in "\u00e9\u4e2d":
        scene = Scene(12, 20)
        scene.text(0, 14, character, 16, RED)
        pictures.add(drawn(scene).data)
    assert len(pictures) == 1


def test_too_large_a_picture_is_refused() -> None:
    with pytest.raises(ConfigError, match="too large"):
        png(Scene(20_000, 20_000))


def test_a_large_picture_is_drawn_smaller() -> None:
    pixels = drawn(Scene(4_000, 3_000), 2)
    assert (pixels.width, pixels.height) == (4_000, 3_000)
