"""JPEG pictures: rotation, scaling, encoding, and a test picture, with Pillow (extra `camera`).

The functions raise ConfigError if Pillow is needed and not installed.
"""

from __future__ import annotations

import io
import time
from typing import Any

from msgspec import Struct

from rostether.errors import SensorError
from rostether.extras import imported_from

DEFAULT_QUALITY = 80


class PictureChange(Struct, frozen=True):
    """Changes to each picture; width and height 0 keep the size, and quality 0 keeps the compression."""

    vflip: bool = False
    hflip: bool = False
    width: int = 0
    height: int = 0
    quality: int = 0

    @property
    def is_none(self) -> bool:
        """Whether pictures stay unchanged."""
        return self == PictureChange()


def pillow() -> Any:
    """Return the module `PIL.Image`. Raises ConfigError if Pillow is not installed."""
    with imported_from("camera", "test pictures and changes to pictures need Pillow"):
        from PIL import Image
    return Image


def changed_jpeg(data: bytes, change: PictureChange) -> bytes:
    """Return a changed JPEG picture. Raises SensorError for invalid data, ConfigError without Pillow."""
    image_module = pillow()
    try:
        with image_module.open(io.BytesIO(data), formats=["JPEG"]) as image:
            if change.width and change.height:
                # Decodes at a reduced size, which is faster.
                image.draft("RGB", (change.width, change.height))
            image.load()
            return _encoded(image, change)
    # Pillow raises SyntaxError for damaged markers.
    except (OSError, ValueError, SyntaxError, image_module.DecompressionBombError) as error:
        raise SensorError(f"a picture is damaged: {error}") from None


def jpeg_of_yuyv(data: bytes, width: int, height: int, change: PictureChange) -> bytes:
    """Return a raw picture (YUV 4:2:2, two bytes per pixel) as JPEG.

    Raises SensorError for too few bytes, ConfigError without Pillow.
    """
    image_module = pillow()
    size = width * height
    if len(data) < 2 * size:
        raise SensorError(f"a picture of {width} x {height} has only {len(data)} bytes")
    data = data[: 2 * size]
    luma = image_module.frombytes("L", (width, height), data[0::2])
    chroma = [
        image_module.frombytes("L", (width // 2, height), data[start::4]).resize((width, height))
        for start in (1, 3)
    ]
    return _encoded(image_module.merge("YCbCr", [luma, *chroma]).convert("RGB"), change)


def draw_test_picture(count: int, change: PictureChange) -> bytes:
    """Return a JPEG picture with color bars, a moving square, a counter and the time.

    Raises ConfigError without Pillow.
    """
    image_module = pillow()
    from PIL import ImageDraw

    width, height = change.width or 640, change.height or 480
    image = image_module.new("RGB", (width, height))
    draw = ImageDraw.Draw(image)
    colors = ("white", "yellow", "cyan", "lime", "magenta", "red", "blue")
    for index, color in enumerate(colors):
        draw.rectangle(
            (index * width // len(colors), 0, (index + 1) * width // len(colors), height * 3 // 4), fill=color
        )
    side = max(2, height // 8)
    left = count * max(1, side // 4) % max(1, width - side)
    draw.rectangle((left, height // 2, left + side, height // 2 + side), fill="black")
    draw.text((8, height * 7 // 8), f"{count}  {time.strftime('%H:%M:%S')}", fill="white")
    return _encoded(image, change)


def _encoded(image: Any, change: PictureChange) -> bytes:
    transpose = pillow().Transpose
    if change.vflip:
        image = image.transpose(transpose.FLIP_TOP_BOTTOM)
    if change.hflip:
        image = image.transpose(transpose.FLIP_LEFT_RIGHT)
    if change.width and change.height and image.size != (change.width, change.height):
        image = image.resize((change.width, change.height))
    output = io.BytesIO()
    image.save(output, "JPEG", quality=change.quality or DEFAULT_QUALITY)
    return output.getvalue()
