from __future__ import annotations

import os
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from rostether.dashboard import map_tiles
from rostether.dashboard.map_tiles import MapTiles
from rostether.errors import ConfigError
from rostether.gateways.websocket.site import Site

PNG = b"\x89PNG tile"


def made(path: Path, kind: str = "png", tiles: int = 1) -> Path:
    with closing(sqlite3.connect(path)) as database, database:
        database.execute("CREATE TABLE metadata (name TEXT, value TEXT)")
        database.execute("CREATE TABLE tiles (zoom_level, tile_column, tile_row, tile_data BLOB)")
        database.execute("INSERT INTO metadata VALUES ('format', ?)", (kind,))
        if tiles:
            # The north-western tile of zoom 1: the file counts rows from the south.
            database.execute("INSERT INTO tiles VALUES (1, 0, 1, ?)", (PNG,))
    database.close()
    return path


def test_tiles_are_read_by_the_rows_of_web_addresses(tmp_path: Path) -> None:
    tiles = MapTiles(made(tmp_path / "map.mbtiles"))
    assert (tiles.content_type, tiles.max_zoom) == ("image/png", 1)
    assert tiles.read(1, 0, 0) == PNG
    assert tiles.read(1, 0, 1) is None
    for place in ((1, 2, 0), (1, 0, -1), (99, 0, 0), (30, 10**9, 0)):
        assert tiles.read(*place) is None


@pytest.mark.parametrize(
    ("kind", "tiles", "reason"), [("pbf", 1, "png, jpg or webp"), ("png", 0, "no tiles")]
)
def test_files_that_cannot_be_shown_are_refused(tmp_path: Path, kind: str, tiles: int, reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        MapTiles(made(tmp_path / "map.mbtiles", kind, tiles))


def test_other_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "map.mbtiles"
    path.write_bytes(b"hello" * 1000)
    with pytest.raises(ConfigError, match=r"not a readable \.mbtiles file"):
        MapTiles(path)


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    path = made(tmp_path / "map.mbtiles")
    tiles = MapTiles(path)
    data = path.read_bytes()
    path.write_bytes(data.replace(b"tabletilestiles", b"tabletil\xffstil\xffs"))
    with pytest.raises(ConfigError, match=r"not a readable \.mbtiles file: it is damaged; give"):
        MapTiles(path)
    assert tiles.read(1, 0, 0) is None


def test_a_site_serves_them(tmp_path: Path) -> None:
    site = Site({"index.html": b""}, tiles=MapTiles(made(tmp_path / "map.mbtiles")))
    assert site.is_download("GET", "/tiles/1/0/0?token=a")
    reply, file = site.open_download("/tiles/1/0/0?token=a")
    assert (reply.status_code, reply.headers["Content-Length"]) == (200, str(len(PNG)))
    assert reply.headers["Content-Type"] == "image/png"
    assert file is not None
    assert file.read() == PNG
    for path in ("/tiles/1/0/1", "/tiles/../1/0", "/tiles/1/0", "/tiles/999/0/0", "/tiles/1/0/0/../../x"):
        reply, file = site.open_download(path)
        assert (reply.status_code, file) == (404, None)
    assert not Site({"index.html": b""}).is_download("GET", "/tiles/1/0/0")


ENDLESS = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c)"


@pytest.mark.parametrize(
    "statements",
    [
        [f"CREATE VIEW metadata AS {ENDLESS} SELECT x AS name, x AS value FROM c"],
        [
            "CREATE TABLE metadata (name, value)",
            f"CREATE VIEW tiles AS {ENDLESS} SELECT -x AS zoom_level, 0 AS tile_data FROM c",
        ],
        ["CREATE VIEW metadata AS SELECT 'format' AS name, zeroblob(500000000) AS value"],
        [
            "CREATE TABLE metadata (name, value)",
            "CREATE TABLE tiles (zoom_level)",
            "INSERT INTO tiles VALUES ('x')",
        ],
    ],
    ids=["endless metadata", "endless tiles", "huge value", "zoom is text"],
)
def test_hostile_files_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, statements: list[str]
) -> None:
    monkeypatch.setattr(map_tiles, "_MAX_STEPS", 500_000)
    path = tmp_path / "map.mbtiles"
    with closing(sqlite3.connect(path)) as database:
        for each in statements:
            database.execute(each)
        database.commit()
    with pytest.raises(ConfigError, match=r"map\.mbtiles (is not a readable|has no tiles)"):
        MapTiles(path)


def test_a_tile_that_is_not_a_picture_is_missing(tmp_path: Path) -> None:
    path = made(tmp_path / "map.mbtiles")
    with closing(sqlite3.connect(path)) as database:
        # As bytes, the number would be two gigabytes of zeros.
        database.execute("UPDATE tiles SET tile_data = 2000000000")
        database.commit()
    assert MapTiles(path).read(1, 0, 0) is None


def test_only_files_are_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "map.mbtiles")
    with pytest.raises(ConfigError, match="is not a file"):
        MapTiles(tmp_path / "map.mbtiles")
