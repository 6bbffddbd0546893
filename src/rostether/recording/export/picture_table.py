"""Pictures of a topic as files, one for each message, named by their times."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from rostether.mechanisms.whole_file import write_whole
from rostether.recording.write_errors import writing
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
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)

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
        with writing(path):
            write_whole(path, message.data)

    def flush(self) -> None:
        """Do nothing: each picture is written immediately."""

    def close(self) -> None:
        """Do nothing: each file is complete."""
