"""A camera of Linux (V4L2), with the package `linuxpy` (extra `camera`)."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncGenerator
from contextlib import aclosing, closing, suppress
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from rostether.errors import SensorError
from rostether.extras import imported_from
from rostether.platform.sensors.jpeg import PictureChange, changed_jpeg, jpeg_of_yuyv, pillow

# A USB camera needs up to 2 s for its first picture.
_FRAME_LIMIT_S = 5.0


class V4l2Camera:
    """A device such as /dev/video0. Some cameras send JPEG; raw pictures of others are encoded here."""

    def __init__(self, path: Path, change: PictureChange) -> None:
        self._video = _video_package()
        pillow()
        self._path = path
        self._change = change

    def check(self) -> None:
        """Raise OSError if the device is missing."""
        self._path.stat()

    async def pictures(self, rate_hz: float) -> AsyncGenerator[bytes, None]:
        """Yield pictures. Raises OSError, SensorError."""
        try:
            async with aclosing(self._captured(rate_hz)) as pictures:
                async for picture in pictures:
                    yield picture
        except OSError as error:
            if error.filename:
                raise
            # Only errors of open() contain the file name.
            raise SensorError(f"{self._path}: {error.strerror or error}") from None

    async def _captured(self, rate_hz: float) -> AsyncGenerator[bytes, None]:
        change = self._change
        with closing(await asyncio.to_thread(self._open)) as device:
            capture = self._video.VideoCapture(device)
            try:
                capture.set_format(change.width or 640, change.height or 480, "MJPG")
                # A driver that cannot deliver the wanted format chooses another one.
                form = capture.get_format()
                # Some drivers cannot set the rate; surplus pictures are dropped.
                with suppress(OSError):
                    capture.set_fps(rate_hz)
                is_jpeg = form.pixel_format.name in ("MJPEG", "JPEG")
                if not is_jpeg:
                    capture.set_format(form.width, form.height, "YUYV")
                    form = capture.get_format()
                    if form.pixel_format.name != "YUYV":
                        raise SensorError(f"{self._path} sends neither JPEG nor YUYV pictures")
                capture.open()
            except self._video.V4L2Error as error:
                raise SensorError(f"{self._path} is not a camera: {error}") from None
            with closing(capture):
                # If the camera scales its pictures, they are not scaled again.
                if (form.width, form.height) == (change.width, change.height):
                    change = replace(change, width=0, height=0)
                async for frame in self._frames(capture, rate_hz):
                    if not is_jpeg:
                        yield await asyncio.to_thread(jpeg_of_yuyv, frame, form.width, form.height, change)
                    elif change.is_none:
                        yield frame
                    else:
                        yield await asyncio.to_thread(changed_jpeg, frame, change)

    async def _frames(self, capture: Any, rate_hz: float) -> AsyncGenerator[bytes, None]:
        loop = asyncio.get_running_loop()
        next_s = loop.time()
        async with aclosing(aiter(capture)) as frames:
            while True:
                try:
                    async with asyncio.timeout(_FRAME_LIMIT_S):
                        frame = await anext(frames)
                except TimeoutError:
                    raise SensorError(f"{self._path} sends no pictures") from None
                # The camera may be faster than the requested rate.
                if loop.time() >= next_s:
                    next_s = max(next_s + 1 / rate_hz, loop.time())
                    yield bytes(frame)

    def _open(self) -> Any:
        device = self._video.Device(str(self._path))
        device.open()
        return device


def _video_package() -> Any:
    with imported_from("camera", "cameras need another package"):
        from linuxpy.video import device
    # The package logs a warning for each picture that is dropped.
    logging.getLogger("linuxpy").setLevel(logging.ERROR)
    return device
