"""NMEA sentences of a GPS receiver as positions, with the package `pynmea2` (extra `gps`); without I/O."""

from __future__ import annotations

import math
from typing import Any

from msgspec import Struct

from rostether.extras import imported_from

# NMEA 0183 allows 82; receivers send longer ones.
MAX_LINE_BYTES = 1024

# The error of one range measurement of a simple receiver, in meters; HDOP multiplies it.
_RANGE_ERROR_M = 5.0

# sensor_msgs/NavSatStatus by the quality in GGA: 2 means corrections by satellites, 4 and 5 by ground
# stations.
_STATUS = {0: -1, 2: 1, 4: 2, 5: 2}
_SERVICE_GPS = 1
_MAX_LATITUDE = 90
_MAX_LONGITUDE = 180
_COVARIANCE_APPROXIMATED = 1


class Position(Struct, frozen=True):
    """A position on the WGS 84 ellipsoid in degrees and meters; NaN without a fix."""

    status: int
    satellites: int
    latitude: float = math.nan
    longitude: float = math.nan
    altitude_m: float = math.nan
    hdop: float = math.nan

    @property
    def has_fix(self) -> bool:
        """Whether the receiver knows where it is."""
        return self.status >= 0

    @property
    def fields(self) -> dict[str, Any]:
        """The fields of sensor_msgs/NavSatFix, without its header."""
        variance = (self.hdop * _RANGE_ERROR_M) ** 2
        is_known = not math.isnan(variance)
        return {
            "status": {"status": self.status, "service": _SERVICE_GPS},
            "latitude": self.latitude,
            "longitude": self.longitude,
            "altitude": self.altitude_m,
            # The error of the altitude is about twice that of the position.
            "position_covariance": [variance, 0, 0, 0, variance, 0, 0, 0, 4 * variance]
            if is_known
            else [0.0] * 9,
            "position_covariance_type": _COVARIANCE_APPROXIMATED if is_known else 0,
        }


class NmeaReader:
    """Splits bytes into sentences and returns their positions."""

    def __init__(self) -> None:
        self._pynmea2 = _nmea_package()
        self._buffer = bytearray()
        self._has_data = False
        self._sentence_count = 0
        self.damaged_count = 0

    def feed(self, data: bytes) -> list[Position]:
        """Return the positions of the sentences that `data` completes; damaged ones are counted."""
        self._has_data |= bool(data)
        self._buffer += data
        *lines, rest = bytes(self._buffer).split(b"\n")
        self._buffer = bytearray(rest[-MAX_LINE_BYTES:])
        return [found for line in lines if (found := self._position(line)) is not None]

    def read_and_clear_problem(self) -> str:
        """Return why no position arrived since the last call."""
        has_data, sentence_count, damaged_count = self._has_data, self._sentence_count, self.damaged_count
        self._has_data, self._sentence_count, self.damaged_count = False, 0, 0
        if not has_data:
            return "it sends nothing; check the port and the cable"
        if damaged_count > sentence_count:
            return "its sentences are damaged; check the baud rate and the cable"
        if not sentence_count:
            return "it sends no NMEA sentences; check the baud rate"
        return "it sends NMEA sentences, but none with a position (GGA); turn them on in the receiver"

    def _position(self, line: bytes) -> Position | None:
        # Receivers also send binary data; a sentence begins with a dollar sign.
        start = line.rfind(b"$")
        if start < 0:
            return None
        try:
            sentence = self._pynmea2.parse(line[start:].decode("ascii").strip(), check=True)
            self._sentence_count += 1
            if getattr(sentence, "sentence_type", "") != "GGA":
                return None
            return _position_of_gga(sentence)
        except (self._pynmea2.ParseError, ValueError, TypeError, AttributeError):
            self.damaged_count += 1
            return None


def _position_of_gga(sentence: Any) -> Position:
    quality = int(sentence.gps_qual or 0)
    satellites = int(sentence.num_sats or 0)
    status = _STATUS.get(quality, 0)
    if status < 0 or not sentence.lat or not sentence.lon:
        return Position(-1, satellites)
    latitude, longitude = sentence.latitude, sentence.longitude
    if sentence.lat_dir not in ("N", "S") or sentence.lon_dir not in ("E", "W"):
        raise ValueError(sentence)
    if abs(latitude) > _MAX_LATITUDE or abs(longitude) > _MAX_LONGITUDE:
        raise ValueError(sentence)
    # GGA has the altitude above the geoid, and the height of the geoid above the ellipsoid.
    altitude_m = _number(sentence.altitude) + float(sentence.geo_sep or 0.0)
    hdop = _number(sentence.horizontal_dil)
    return Position(status, satellites, latitude, longitude, altitude_m, hdop)


def _number(field: object) -> float:
    # pynmea2 returns None or "" for an empty field.
    return math.nan if field in (None, "") else float(str(field))


def _nmea_package() -> Any:
    """Return the package `pynmea2`. Raises ConfigError if it is not installed."""
    with imported_from("gps", "GPS needs another package"):
        import pynmea2
    return pynmea2
