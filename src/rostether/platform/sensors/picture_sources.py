"""Sources of a camera's pictures: a folder of JPEG files, or test pictures."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import AsyncGenerator
from pathlib import Path
from typing import Protocol

from rostether.errors import SensorError
from rostether.platform.sensors.jpeg import PictureChange, changed_jpeg, draw_test_picture, pillow
from rostether.platform.sensors.readings import Pace, paced

# Larger than the picture of any camera.
_MAX_PICTURE_BYTES = 32 << 20
# The number of files in a folder, which is listed again for each round.
MAX_FILES = 100_000


class PictureSource(Protocol):
    """A source of JPEG pictures."""

    def check(self) -> None:
        """Raise OSError or SensorError if the source is missing; opens nothing."""

    def pictures(self, rate_hz: float) -> AsyncGenerator[bytes, None]:
        """Open the source and yield JPEG pictures, at most `rate_hz` a second.

        Raises OSError, SensorError.
        """


class DrawnTestPictures:
    """Draws pictures for tests without a camera."""

    def __init__(self, change: PictureChange) -> None:
        pillow()
        self._change = change

    def check(self) -> None:
        """Do nothing: test pictures are always available."""

    def pictures(self, rate_hz: float) -> AsyncGenerator[bytes, None]:
        """Yield pictures with a moving square and a counter."""
        counts = itertools.count()
        return paced(lambda: draw_test_picture(next(counts), self._change), rate_hz)


class PictureFolder:
    """The JPEG files of a folder, sorted by name, in a loop."""

    def __init__(self, folder: Path, change: PictureChange) -> None:
        if not change.is_none:
            pillow()
        self._folder = folder
        self._change = change
        # A damaged file ends a run; the next run continues after it, so that it does not hide the others.
        self._last_name = ""

    def check(self) -> None:
        """Raise OSError or SensorError if the folder has no pictures."""
        self._files()

    async def pictures(self, rate_hz: float) -> AsyncGenerator[bytes, None]:
        """Yield the content of the files."""
        pace = Pace(rate_hz)
        while True:
            for path in await asyncio.to_thread(self._files):
                if path.name <= self._last_name:
                    continue
                self._last_name = path.name
                yield await asyncio.to_thread(self._read, path)
                await pace.wait()
            self._last_name = ""

    def _files(self) -> list[Path]:
        names = itertools.islice(self._folder.iterdir(), MAX_FILES)
        # Opening a named pipe would wait for its writer.
        found = sorted(each for each in names if each.suffix.lower() in (".jpg", ".jpeg") and each.is_file())
        if not found:
            raise SensorError(f"{self._folder} has no .jpg files")
        return found

    def _read(self, path: Path) -> bytes:
        with path.open("rb") as file:
            data = file.read(_MAX_PICTURE_BYTES)
        if not data.startswith(b"\xff\xd8"):
            raise SensorError(f"{path} is not a JPEG picture")
        try:
            return data if self._change.is_none else changed_jpeg(data, self._change)
        except SensorError as error:
            raise SensorError(f"{path}: {error}") from None
