"""How chunks of bags are compressed: not at all, by bz2, or as an LZ4 frame (extra `recording`)."""

from __future__ import annotations

import bz2
from typing import Any

from rostether.errors import ConfigError, RecordingError

NONE = "none"
BZ2 = "bz2"
LZ4 = "lz4"
COMPRESSIONS = (NONE, BZ2, LZ4)

MAX_CHUNK_BYTES = 1 << 30
"""No recorder makes chunks of a gigabyte; a broken size must not eat the memory."""


def check_compression(name: str) -> None:
    """Raise ConfigError when chunks cannot be compressed in that way here."""
    if name not in COMPRESSIONS:
        raise ConfigError(f"no compression is called {name!r}; there are {', '.join(COMPRESSIONS)}")
    if name == LZ4:
        _lz4_frame()


def compress(name: str, data: bytes) -> bytes:
    """Return a chunk's data compressed. Raises ConfigError."""
    if name == BZ2:
        return bz2.compress(data)
    if name == LZ4:
        frame = _lz4_frame()
        # ROS's own decoder knows only blocks that stand alone, and no content size.
        return bytes(
            frame.compress(
                data,
                block_size=frame.BLOCKSIZE_MAX4MB,
                block_linked=False,
                content_checksum=True,
                store_size=False,
            )
        )
    return data


def decompress(name: str, data: bytes, size_bytes: int) -> bytes:
    """Return a chunk's data, which must have that size. Raises RecordingError, ConfigError."""
    if size_bytes > MAX_CHUNK_BYTES:
        raise RecordingError(f"a chunk says that it holds {size_bytes} bytes")
    try:
        if name == NONE:
            plain = data
        elif name == BZ2:
            plain = bz2.BZ2Decompressor().decompress(data, max_length=size_bytes + 1)
        elif name == LZ4:
            plain = bytes(_lz4_frame().LZ4FrameDecompressor().decompress(data, max_length=size_bytes + 1))
        else:
            raise RecordingError(f"a chunk is compressed by {name!r}, which nobody knows")
    except (OSError, RuntimeError, EOFError, ValueError) as error:
        raise RecordingError(f"a chunk compressed by {name} is broken ({error})") from None
    if len(plain) != size_bytes:
        raise RecordingError(f"a chunk holds {len(plain)} bytes in place of {size_bytes}")
    return plain


def _lz4_frame() -> Any:
    try:
        import lz4.frame
    except ImportError:
        raise ConfigError("LZ4 is not installed; type: pip install 'rostether[recording]'") from None
    return lz4.frame
