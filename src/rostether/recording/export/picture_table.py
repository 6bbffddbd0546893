"""Pictures of a topic as files, one for each message, named by their times."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from rostether.errors import RecordingError
from rostether.mechanisms.text import write_failure
from rostether.mechanisms.whole_file import write_whole
from rostether.rostime import NS_PER_S
from rostether.serde.values import Message

PICTURE_TYPE = "sensor_msgs/CompressedImage"


class PictureTable:
    """Writes the pictures of sensor_msgs/CompressedImage unchanged as .jpg and .png files."""

    def __init__(self, folder: Path) -> None:
        """Create the folder. Raises RecordingError."""
        self._folder = folder
        self._last = ("", "")
        self._same_count = 0
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise RecordingError(write_failure(folder, error)) from None

    def add(self, time_ns: int, message: Message) -> None:
        """Write a picture. Raises RecordingError."""
        seconds, nanoseconds = divmod(time_ns, NS_PER_S)
        extension = "png" if "png" in message.format.lower() else "jpg"
        stem = f"{datetime.fromtimestamp(seconds):%Y-%m-%d-%H-%M-%S}.{nanoseconds // 1000:06d}"
        # Several pictures may have one time.
        self._same_count = self._same_count + 1 if (stem, extension) == self._last else 1
        self._last = (stem, extension)
        number = f"-{self._same_count}" if self._same_count > 1 else ""
        path = self._folder / f"{stem}{number}.{extension}"
        try:
            write_whole(path, message.data)
        except OSError as error:
            raise RecordingError(write_failure(path, error)) from None

    def flush(self) -> None:
        """Do nothing: each picture is written immediately."""

    def close(self) -> None:
        """Do nothing: each file is complete."""
