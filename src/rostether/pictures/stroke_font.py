"""The letters of PNG pictures: strokes on a grid, 4 units wide, capitals 6 high, drawn at any size.

Each stroke is a row of points, each point two digits: x from 0 (left) to 4, y from 0 (top of capitals) to
6 (base line) and 8 (below it).
"""

from __future__ import annotations

from functools import cache

from rostether.pictures.scene import ADVANCE, Point

BASE_LINE = 6
UNITS_PER_SIZE = 10.0
"""Units of the grid in a font size; a character takes 6 of them, its gap included."""

_BOX = "0040460600"
_GLYPHS = {
    "!": "2024 2626", '"': "1012 3032", "#": "1016 3036 0242 0444", "$": "413010010213334445361605 2026",
    "%": "4006 1010 3636", "&": "4612112031320405162644", "'": "2022", "(": "30212536", ")": "10212516",
    "*": "2125 0244 4204", "+": "2125 0343", ",": "2617", "-": "0343", ".": "2626", "/": "0640",
    "0": "103041453616050110 1531", "1": "112026 1636", "2": "01103041420646",
    "3": "011030414233 13334445361605", "4": "36300444", "5": "400002324345361605",
    "6": "413010010516364544331304", "7": "004016", "8": "103041423313020110 1304051636454433",
    "9": "051636454130100102133342", ":": "2323 2626", ";": "2323 2617", "<": "411345", "=": "0242 0444",
    ">": "013305", "?": "01103041422324 2626", "@": "4536160501103041443424233242",
    "A": "062046 1434", "B": "06003041423303 3344453606", "C": "4130100105163645", "D": "06003041453606",
    "E": "40000646 0333", "F": "400006 0333", "G": "41301001051636454323", "H": "0006 4046 0343",
    "I": "1030 2026 1636", "J": "404536160504", "K": "0006 400346", "L": "000646", "M": "0600234046",
    "N": "06004640", "O": "103041453616050110", "P": "06003041423303", "Q": "103041453616050110 2446",
    "R": "06003041423303 2346", "S": "413010010213334445361605", "T": "0040 2026", "U": "000516364540",
    "V": "002640", "W": "0016233640", "X": "0046 4006", "Y": "002340 2326", "Z": "00400646",
    "[": "30101636", "\\": "0046", "]": "10303616", "^": "022042", "_": "0747", "`": "1021",
    "a": "4246 4332120305163645", "b": "0006 0312324345361605", "c": "4332120305163645",
    "d": "4046 4332120305163645", "e": "04444332120305163645", "f": "40302126 0232",
    "g": "4332120305163645 4247381807", "h": "0006 0312324346", "i": "2226 2020", "j": "3237281807 3030",
    "k": "0006 420446", "l": "10202536", "m": "0206 03122326 23324346", "n": "0206 0312324346",
    "o": "123243453616050312", "p": "0208 0312324345361605", "q": "4248 4332120305163645",
    "r": "0206 04123243", "s": "43321203143445361605", "t": "20253645 0242", "u": "0205163645 4246",
    "v": "022642", "w": "0216243642", "x": "0246 4206", "y": "0205163645 4247381807", "z": "02420646",
    "{": "30212213242536", "|": "2027", "}": "10212233242516", "~": "0413243342", " ": "",
}  # fmt: skip


def strokes(text: str, x: float, y: float, size: float) -> list[list[Point]]:
    """Return the lines that write a text from `x` on, on the base line `y`; unknown characters are boxes."""
    scale = size / UNITS_PER_SIZE
    margin = (ADVANCE * UNITS_PER_SIZE - 4) / 2
    found = []
    for place, character in enumerate(text):
        left = x + size * ADVANCE * place + margin * scale
        found += [
            [(left + scale * right, y + scale * (down - BASE_LINE)) for right, down in stroke]
            for stroke in _strokes_of(character)
        ]
    return found


@cache
def _strokes_of(character: str) -> tuple[tuple[tuple[int, int], ...], ...]:
    return tuple(
        tuple((int(stroke[at]), int(stroke[at + 1])) for at in range(0, len(stroke), 2))
        for stroke in _GLYPHS.get(character, _BOX).split()
    )
