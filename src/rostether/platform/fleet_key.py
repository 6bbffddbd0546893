"""The key of a fleet: a file of 32 hexadecimal digits, the same on all its machines and boards."""

from __future__ import annotations

from pathlib import Path

from rostether.errors import ConfigError
from rostether.mechanisms.text import read_failure
from rostether.platform.siphash import KEY_BYTES

# A key with its line end is shorter; a larger file is not a key.
_MAX_KEY_FILE_BYTES = 1024


def read_fleet_key(path: str) -> bytes:
    """Return the key in a file of 32 hexadecimal digits, the same on all machines and boards of a fleet.

    Raises ConfigError, whose text never contains the key.
    """
    try:
        with Path(path).expanduser().open("rb") as file:
            text = file.read(_MAX_KEY_FILE_BYTES).strip()
    except OSError as error:
        raise ConfigError(f"the fleet's key: {read_failure(path, error)}") from None
    try:
        key = bytes.fromhex(text.decode("ascii"))
    except ValueError:
        key = b""
    if len(key) != KEY_BYTES:
        raise ConfigError(
            f"{path}: a fleet's key is {2 * KEY_BYTES} hexadecimal digits; "
            "make one with: openssl rand -hex 16"
        )
    return key
