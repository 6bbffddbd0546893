from __future__ import annotations

from rostether.pictures.scene import text_width
from rostether.pictures.stroke_font import strokes


def test_letters_stay_in_their_cells() -> None:
    for code in range(32, 127):
        for stroke in strokes(chr(code), 100.0, 50.0, 10.0):
            assert len(stroke) >= 2
            assert all(100 <= x <= 100 + text_width("x", 10.0) for x, _ in stroke)
            assert all(50 - 6 <= y <= 50 + 2 for _, y in stroke)


def test_text_goes_on_to_the_right() -> None:
    first, second = strokes("ll", 0.0, 0.0, 20.0)
    assert [(x + 12.0, y) for x, y in first] == second
