"""Reads numbers from system files: /sys/bus/iio (with its unit), or any file that starts with a number."""

from __future__ import annotations

import re
from collections.abc import AsyncGenerator
from pathlib import Path

from rostether.errors import SensorError
from rostether.platform.sensors.readings import paced

# Longer than every number; a larger file is a mistake.
_MAX_FILE_BYTES = 4096

# in_voltage0_raw, in_temp_raw, in_accel_x_raw, in_distance_input: the kind and the channel.
_IIO_FILE = re.compile(r"in_([a-z]+(?:relative)?)(\d*)(.*)_(raw|input)")

# Source: Linux, Documentation/ABI/testing/sysfs-bus-iio. Kinds in thousandths of the unit.
_IIO_THOUSANDTHS = {"voltage": "V", "current": "A", "temp": "\N{DEGREE SIGN}C", "humidityrelative": "%"}
_IIO_UNITS = {
    "accel": "m/s\N{SUPERSCRIPT TWO}",
    "anglvel": "rad/s",
    "distance": "m",
    "illuminance": "lx",
    "pressure": "kPa",
    "resistance": "\N{OHM SIGN}",
}


def read_number(path: Path) -> float:
    """Return the number at the start of a file. Raises OSError, SensorError."""
    with path.open("rb") as file:
        text = file.read(_MAX_FILE_BYTES)
    try:
        return float(text.split()[0])
    except (ValueError, IndexError):
        raise SensorError(
            f"{path} does not start with a number, but with {text[:20].decode(errors='replace')!r}"
        ) from None


class NumberFile:
    """A file that starts with a number; `unit` is the unit of an iio channel, else empty."""

    def __init__(self, path: Path) -> None:
        self.path = path
        found = _IIO_FILE.fullmatch(path.name)
        self._kind, self._channel, self._axis, self._form = found.groups() if found else ("", "", "", "")
        self.unit = _IIO_THOUSANDTHS.get(self._kind) or _IIO_UNITS.get(self._kind, "")

    def read(self) -> float:
        """Return the value in its unit; an ADC on I2C may need 0.1 s. Raises OSError, SensorError."""
        value = read_number(self.path)
        if self._form == "raw":
            value = (value + self._property("offset", 0.0)) * self._property("scale", 1.0)
        return value / 1000 if self._kind in _IIO_THOUSANDTHS else value

    def readings(self, rate_hz: float) -> AsyncGenerator[float, None]:
        """Yield the value `rate_hz` times a second. Raises OSError, SensorError."""
        return paced(self.read, rate_hz)

    def _property(self, name: str, default: float) -> float:
        # A channel has its own file, or shares one with all channels of its kind.
        for stem in (f"in_{self._kind}{self._channel}{self._axis}", f"in_{self._kind}"):
            path = self.path.with_name(f"{stem}_{name}")
            if path.exists():
                return read_number(path)
        return default
