"""Map tiles of one .mbtiles file, so that the dashboard shows streets without internet.

An .mbtiles file is an SQLite database (https://github.com/mapbox/mbtiles-spec, version 1.3).
"""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

from rostether.errors import ConfigError

# A tile of this zoom level shows 2.4 m at the equator: 1 cm for each pixel.
_MAX_ZOOM = 24
# A picture of 256 x 256 pixels has about 20 kB.
_MAX_TILE_BYTES = 2 << 20
# Steps of SQLite's virtual machine: a view in a file may be a query that never ends. A tile needs about a
# hundred, without an index about five for each tile of the file; 20 million take a second.
_MAX_STEPS = 20_000_000
_STEPS_AT_ONCE = 100_000
# Python cannot decode SQLite's error when it quotes bytes of a damaged file.
_DAMAGE = (sqlite3.Error, UnicodeDecodeError)
_TYPES = {"png": "image/png", "jpg": "image/jpeg", "jpeg": "image/jpeg", "webp": "image/webp"}


class MapTiles:
    """The tiles of one file. Its methods read the disk."""

    def __init__(self, path: Path) -> None:
        """Check a file. Raises ConfigError with the reason why it cannot be used."""
        self._path = path
        if not path.is_file():
            # Opening a FIFO would wait for a writer.
            raise ConfigError(f"{path} is not a file; give an .mbtiles file")
        try:
            with closing(self._connect()) as database:
                found = database.execute("SELECT value FROM metadata WHERE name = 'format'").fetchone()
                max_zoom = _max_zoom(database)
        except _DAMAGE as error:
            reason = "it is damaged" if isinstance(error, UnicodeDecodeError) else error
            raise ConfigError(
                f"{path} is not a readable .mbtiles file: {reason}; give an .mbtiles file with pictures"
            ) from None
        kind = str(found[0] if found is not None else "png").lower()
        if kind not in _TYPES:
            raise ConfigError(
                f"{path} has tiles of the format {kind[:20]!r}; the page shows pictures: png, jpg or webp"
            )
        if max_zoom is None:
            raise ConfigError(f"{path} has no tiles; give an .mbtiles file with pictures")
        self.content_type = _TYPES[kind]
        self.max_zoom = max_zoom

    def read(self, zoom: int, column: int, row: int) -> bytes | None:
        """Return a tile, None if there is none; rows count from the north, as in web addresses."""
        if not (0 <= zoom <= _MAX_ZOOM and 0 <= column < 1 << zoom and 0 <= row < 1 << zoom):
            return None
        # Rows of the file count from the south.
        arguments = (zoom, column, (1 << zoom) - 1 - row, _MAX_TILE_BYTES)
        query = (
            "SELECT tile_data FROM tiles WHERE zoom_level = ? AND tile_column = ? AND tile_row = ? "
            "AND length(tile_data) <= ?"
        )
        try:
            with closing(self._connect()) as database:
                found = database.execute(query, arguments).fetchone()
        except _DAMAGE:
            # The memory card was removed; the map stays empty there.
            return None
        # A column of SQLite holds values of any type.
        return found[0] if found is not None and isinstance(found[0], bytes) else None

    def _connect(self) -> sqlite3.Connection:
        # Each request opens a connection, because a connection belongs to one thread.
        database = sqlite3.connect(f"{self._path.resolve().as_uri()}?mode=ro", uri=True)
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, 2 * _MAX_TILE_BYTES)
        turns = iter(range(_MAX_STEPS // _STEPS_AT_ONCE))
        database.set_progress_handler(lambda: next(turns, None) is None, _STEPS_AT_ONCE)
        return database


def _max_zoom(database: sqlite3.Connection) -> int | None:
    """Return the highest zoom level that the page can show, None without tiles."""
    # Each query uses the file's index, even through a view; max() would read all tiles of a view.
    for zoom in range(_MAX_ZOOM, -1, -1):
        if database.execute("SELECT 1 FROM tiles WHERE zoom_level = ? LIMIT 1", (zoom,)).fetchone():
            return zoom
    return None
