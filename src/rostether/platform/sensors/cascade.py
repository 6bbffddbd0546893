"""Finds objects in pictures with a cascade classifier (Viola and Jones) of OpenCV (extra `detection`)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from msgspec import Struct

from rostether.errors import ConfigError, SensorError
from rostether.extras import imported_from, install_command
from rostether.mechanisms.text import first_line
from rostether.platform.sensors.jpeg import DEFAULT_QUALITY

# Where Debian and Raspberry Pi OS (package opencv-data) install the files that PyPI's OpenCV contains.
_SYSTEM_FOLDER = Path("/usr/share/opencv4/haarcascades")
# A noisy picture must not fill a message.
_MAX_REGIONS = 100

_GREEN_BGR = (0, 255, 0)
_LINE_PIXELS = 2


class Region(Struct, frozen=True):
    """A rectangle of a picture, in pixels from its upper left corner: sensor_msgs/RegionOfInterest."""

    x_offset: int
    y_offset: int
    width: int
    height: int


class CascadeDetector:
    """The classifier in a cascade file (XML). A name without a folder may be a file that comes with OpenCV.

    Raises ConfigError for a file that is not a cascade, and if OpenCV is not installed.
    """

    def __init__(self, file: Path) -> None:
        self._cv2 = _opencv()
        # The OpenCV of a Linux distribution has no module `data`.
        data = getattr(self._cv2, "data", None)
        folder = Path(data.haarcascades) if data is not None else _SYSTEM_FOLDER
        bundled = folder / file
        path = bundled if not file.exists() and bundled.exists() else file
        self.name = path.stem
        self._classifier = self._cv2.CascadeClassifier()
        try:
            is_loaded = self._classifier.load(str(path))
        except self._cv2.error:
            is_loaded = False
        if not is_loaded:
            raise ConfigError(
                f"{file} is not a cascade file of OpenCV; some are in {folder}, such as "
                "haarcascade_frontalface_default.xml"
            )

    def detect(self, picture: bytes) -> tuple[list[Region], bytes]:
        """Return the regions in a JPEG picture, and the picture with a box around each.

        Raises SensorError for data that is not a picture.
        """
        import numpy as np

        cv2 = self._cv2
        try:
            image = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR)
            if image is None:
                raise SensorError("a picture is damaged")
            gray = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
            found = self._classifier.detectMultiScale(gray)[:_MAX_REGIONS]
            regions = [Region(*(int(each) for each in box)) for box in found]
            if not regions:
                return [], picture
            for box in found:
                cv2.rectangle(image, box, _GREEN_BGR, _LINE_PIXELS)
            _, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, DEFAULT_QUALITY])
        except cv2.error as error:
            raise SensorError(f"a picture is damaged: {first_line(error)}") from None
        return regions, encoded.tobytes()


def _opencv() -> Any:
    """Return the module `cv2`. Raises ConfigError if it is not installed, or has no cascades."""
    with imported_from("detection", "~classifier needs OpenCV"):
        import cv2
    # OpenCV 5 has moved them to its extra modules.
    if not hasattr(cv2, "CascadeClassifier"):
        raise ConfigError(
            f"OpenCV {cv2.__version__} has no cascades; install version 4: {install_command('detection')}"
        )
    # OpenCV prints its own line for each file that it cannot read.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    return cv2
