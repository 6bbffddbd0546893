"""The camera of a Raspberry Pi, with the package `picamera2` of Raspberry Pi OS."""

from __future__ import annotations

import asyncio
import importlib.util
import io
from collections.abc import AsyncGenerator
from typing import Any

from rostether.errors import ConfigError, SensorError
from rostether.platform.sensors.jpeg import DEFAULT_QUALITY, PictureChange
from rostether.platform.sensors.readings import Pace


def has_picamera2() -> bool:
    """Return whether the package is installed."""
    return importlib.util.find_spec("picamera2") is not None


class RaspberryCamera:
    """The first camera. The hardware rotates, scales and encodes pictures.

    Raises ConfigError if picamera2 is not installed.
    """

    def __init__(self, change: PictureChange) -> None:
        if not has_picamera2():
            raise ConfigError(
                "picamera2 is not installed; run: sudo apt install python3-picamera2, and use a virtual "
                "environment made with --system-site-packages"
            )
        self._change = change

    def check(self) -> None:
        """Do nothing: only opening shows whether there is a camera."""

    async def pictures(self, rate_hz: float) -> AsyncGenerator[bytes, None]:
        """Yield pictures. Raises SensorError."""
        camera = await asyncio.to_thread(self._open)
        pace = Pace(rate_hz)
        try:
            while True:
                yield await asyncio.to_thread(_capture, camera)
                await pace.wait()
        finally:
            await asyncio.shield(asyncio.to_thread(camera.close))

    def _open(self) -> Any:
        import libcamera
        from picamera2 import Picamera2

        change = self._change
        try:
            camera = Picamera2()
            size = (change.width or 640, change.height or 480)
            turn = libcamera.Transform(hflip=change.hflip, vflip=change.vflip)
            camera.configure(camera.create_video_configuration(main={"size": size}, transform=turn))
            camera.options["quality"] = change.quality or DEFAULT_QUALITY
            camera.start()
        except (RuntimeError, IndexError) as error:
            raise SensorError(f"the camera cannot be opened: {error}") from None
        return camera


def _capture(camera: Any) -> bytes:
    data = io.BytesIO()
    camera.capture_file(data, format="jpeg")
    return data.getvalue()
