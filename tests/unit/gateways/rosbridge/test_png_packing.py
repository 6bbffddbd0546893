from __future__ import annotations

import base64
import io
import json
import struct
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from rostether.errors import RemoteProtocolError
from rostether.gateways.rosbridge.png_packing import pack_png, unpack_png


def data_of(message: str) -> str:
    fields = json.loads(message)
    assert fields["op"] == "png"
    return str(fields["data"])


def picture_of(content: bytes, mode: str, size: tuple[int, int], **options: object) -> str:
    file = io.BytesIO()
    Image.frombytes(mode, size, content).save(file, "png", **options)
    return base64.b64encode(file.getvalue()).decode()


@given(
    st.text(st.characters(exclude_categories=["Cs"]), min_size=1).filter(lambda text: text[-1] not in "\n\0")
)
def test_a_text_comes_back(text: str) -> None:
    assert unpack_png(data_of(pack_png(text)), 1 << 20) == text


@pytest.mark.parametrize("text", ["{}", '{"op":"publish","msg":{"data":"ü"}}', "x" * 100_000])
def test_another_library_reads_our_pictures(text: str) -> None:
    image = Image.open(io.BytesIO(base64.b64decode(data_of(pack_png(text)))))
    assert image.mode == "RGB"
    assert image.tobytes().decode().rstrip("\n") == text


@pytest.mark.parametrize(("mode", "channels"), [("L", 1), ("RGB", 3), ("RGBA", 4), ("LA", 2)])
def test_pictures_of_another_library_are_read(mode: str, channels: int) -> None:
    # Repetitive as JSON is: the library then uses several row filters.
    text = json.dumps([{"x": index, "y": index * 2} for index in range(200)])
    width = 40
    height = -(-len(text) // (width * channels))
    content = text.encode().ljust(width * height * channels, b"\n")
    assert unpack_png(picture_of(content, mode, (width, height)), 1 << 20) == text


@pytest.mark.parametrize("kind", [0, 1, 2, 3, 4])
def test_every_row_filter_is_undone(kind: int) -> None:
    row, above, pixel = b"abcdef", b"012345", 3

    def guess(index: int) -> int:
        left = row[index - pixel] if index >= pixel else 0
        corner = above[index - pixel] if index >= pixel else 0
        up = above[index]
        nearest = min((left, up, corner), key=lambda each: abs(left + up - corner - each))
        return (0, left, up, (left + up) // 2, nearest)[kind]

    filtered = bytes((row[index] - guess(index)) % 256 for index in range(len(row)))
    rows = b"\0" + above + bytes([kind]) + filtered
    assert unpack_png(hand_made(2, 2, rows), 100) == "012345abcdef"


def hand_made(width: int, height: int, rows: bytes, depth: int = 8) -> str:
    def chunk(kind: bytes, content: bytes) -> bytes:
        return (
            struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        )

    header = struct.pack(">IIBBBBB", width, height, depth, 2, 0, 0, 0)
    picture = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows))
    return base64.b64encode(picture + chunk(b"IEND", b"")).decode()


@pytest.mark.parametrize(
    "data",
    [
        "",
        "!!!",
        "é",
        "AAAA",
        base64.b64encode(b"\x89PNG\r\n\x1a\n").decode(),
        base64.b64encode(b"\x89PNG\r\n\x1a\n\xff\xff\xff\xffIHDR").decode(),
        hand_made(2, 2, b"\0" * 3),
        hand_made(2, 2, b"\x09" + b"\0" * 13),
        hand_made(2, 1, b"\0" + b"\xff" * 6),
        hand_made(0, 5, b"\0" * 5),
        hand_made(2, 1, b"\0" * 14, depth=16),
        hand_made(1 << 30, 1 << 30, b""),
        hand_made(100, 100, b"\0" * 30_100),
    ],
)
def test_what_holds_no_text_is_reported(data: str) -> None:
    with pytest.raises(RemoteProtocolError, match="png: "):
        unpack_png(data, 10_000)


def test_large_pictures_need_rows_without_filters() -> None:
    width = 1000
    rows = (b"\1" + b"a" + b"\0" * (3 * width - 1)) * 100
    with pytest.raises(RemoteProtocolError, match="row filters"):
        unpack_png(hand_made(width, 100, rows), 1 << 20)
    plain = (b"\0" + b"a" * (3 * width)) * 100
    assert unpack_png(hand_made(width, 100, plain), 1 << 20) == "a" * 300_000
