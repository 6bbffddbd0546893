"""Files that a gateway serves by plain GET, such as the dashboard page.

All files are compressed once, when the site is made. A request only looks up its path in a table,
so no path leads out of the folder.
"""

from __future__ import annotations

import gzip
import hashlib
import io
import mimetypes
import os
import re
from collections.abc import Callable, Iterable, Mapping
from http import HTTPStatus
from pathlib import Path
from typing import BinaryIO, Protocol, TypeAlias
from urllib.parse import quote, unquote

from msgspec import Struct
from websockets.datastructures import Headers
from websockets.http11 import Response

INDEX = "index.html"
_DOWNLOADS = "/recordings/"
TILES = "/tiles/"
_TILE = re.compile(r"/tiles/(\d{1,2})/(\d{1,9})/(\d{1,9})")

# Only scripts, styles and images of this page; requests only to this server, but WebSockets to any gateway;
# no embedding in frames.
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self' ws: wss:; worker-src 'self' blob:; manifest-src 'self'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)

# The headers of every response.
_ALWAYS = (
    ("Content-Security-Policy", POLICY),
    ("X-Content-Type-Options", "nosniff"),
    ("Referrer-Policy", "no-referrer"),
    ("Cache-Control", "no-cache"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
)
_VARY = ("Vary", "Accept-Encoding")

# The system's table of types may lack these or name them differently.
_TYPES = {
    ".js": "text/javascript; charset=utf-8",
    ".mjs": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".json": "application/json",
    ".map": "application/json",
    ".svg": "image/svg+xml",
    ".webmanifest": "application/manifest+json",
    ".crt": "application/x-x509-ca-cert",
    ".wasm": "application/wasm",
    ".woff2": "font/woff2",
}


class _SiteFile(Struct, frozen=True):
    """One file: its content, the compressed content if that is smaller, and the tag of its version."""

    content_type: str
    content: bytes
    compressed: bytes | None
    tag: str

    @classmethod
    def of(cls, name: str, content: bytes) -> _SiteFile:
        """Compress a file and compute its tag, once for all requests."""
        # Without a timestamp, so that the same content always has the same bytes.
        compressed = gzip.compress(content, mtime=0)
        return cls(
            content_type=_content_type(name),
            content=content,
            compressed=compressed if len(compressed) < len(content) else None,
            tag=hashlib.sha256(content).hexdigest()[:32],
        )


# Finds a file by its name, None if there is none; may read a folder.
FindFile: TypeAlias = Callable[[str], Path | None]


class Tiles(Protocol):
    """Map tiles, all of one type."""

    @property
    def content_type(self) -> str:
        """The type of every tile."""

    def read(self, zoom: int, column: int, row: int) -> bytes | None:
        """Return a tile, None if there is none; may read the disk."""


class Site:
    """A fixed set of files by their paths without the leading slash; `/` is `index.html`.

    `find_download` finds files that are too large for memory; they need the token.
    """

    def __init__(
        self, files: Mapping[str, bytes], find_download: FindFile | None = None, tiles: Tiles | None = None
    ) -> None:
        self._find_download = find_download
        self._tiles = tiles
        self._files = {f"/{name}": _SiteFile.of(name, content) for name, content in files.items()}
        if index := self._files.get(f"/{INDEX}"):
            self._files["/"] = index

    def is_download(self, method: str, path: str) -> bool:
        """Return whether `open_download` answers a request."""
        if method != "GET":
            return False
        is_tile = self._tiles is not None and path.startswith(TILES)
        return is_tile or (self._find_download is not None and path.startswith(_DOWNLOADS))

    def open_download(self, path: str) -> tuple[Response, BinaryIO | None]:
        """Return the header of the response, and the open file that follows it if there is one.

        Reads the disk.
        """
        if path.startswith(TILES):
            return self._open_tile(path)
        assert self._find_download is not None
        name = unquote(path.removeprefix(_DOWNLOADS).partition("?")[0])
        found = self._find_download(name)
        try:
            opened = found.open("rb") if found is not None else None
        except OSError:
            opened = None
        if opened is None:
            return refusal(HTTPStatus.NOT_FOUND, "there is no such recording; reload the list"), None
        size = os.fstat(opened.fileno()).st_size
        headers = (
            ("Content-Type", "application/octet-stream"),
            # RFC 8187: the form for names with any character.
            ("Content-Disposition", f"attachment; filename*=UTF-8''{quote(name, safe='')}"),
        )
        return _response(HTTPStatus.OK, headers, length=size), opened

    def _open_tile(self, path: str) -> tuple[Response, BinaryIO | None]:
        assert self._tiles is not None
        tile_path = _TILE.fullmatch(path.partition("?")[0])
        tile = self._tiles.read(*map(int, tile_path.groups())) if tile_path else None
        if tile is None:
            return refusal(HTTPStatus.NOT_FOUND, "the map has no such tile"), None
        headers = (("Content-Type", self._tiles.content_type),)
        return _response(HTTPStatus.OK, headers, length=len(tile)), io.BytesIO(tile)

    def reply(self, method: str, path: str, headers: Headers) -> Response:
        """Return the response to a plain request."""
        if method not in ("GET", "HEAD"):
            return refusal(
                HTTPStatus.METHOD_NOT_ALLOWED, "only GET and HEAD are allowed", ("Allow", "GET, HEAD")
            )
        file = self._files.get(path.partition("?")[0])
        if file is None:
            return refusal(HTTPStatus.NOT_FOUND, "no such file; the page is at /", is_head=method == "HEAD")
        body, tag = file.content, f'"{file.tag}"'
        encoding: tuple[tuple[str, str], ...] = ()
        if file.compressed is not None and _accepts_gzip(headers.get_all("Accept-Encoding")):
            body, encoding, tag = file.compressed, (("Content-Encoding", "gzip"),), f'"{file.tag}-gzip"'
        if _has_tag(headers.get_all("If-None-Match"), tag):
            return _response(HTTPStatus.NOT_MODIFIED, (_VARY, ("ETag", tag)))
        described = (_VARY, ("ETag", tag), ("Content-Type", file.content_type), *encoding)
        return _response(HTTPStatus.OK, described, b"" if method == "HEAD" else body, length=len(body))


def refusal(status: HTTPStatus, text: str, *more: tuple[str, str], is_head: bool = False) -> Response:
    """Return a response with one line of text that explains why there is no file."""
    body = f"{text}\n".encode("utf-8", "replace")
    headers = (("Content-Type", "text/plain; charset=utf-8"), *more)
    return _response(status, headers, b"" if is_head else body, length=len(body))


def _response(
    status: HTTPStatus, headers: Iterable[tuple[str, str]], body: bytes = b"", *, length: int = 0
) -> Response:
    """Return a response; `length` is the size of the whole body, which may be sent later, or never."""
    described = Headers([*_ALWAYS, *headers])
    if status is not HTTPStatus.NOT_MODIFIED:
        described["Content-Length"] = str(length)
    described["Connection"] = "close"
    return Response(status.value, status.phrase, described, body)


def _content_type(name: str) -> str:
    known = _TYPES.get(Path(name).suffix.lower())
    return known or mimetypes.guess_type(name)[0] or "application/octet-stream"


def _accepts_gzip(values: list[str]) -> bool:
    for each in ",".join(values).split(","):
        coding, _, weight = each.partition(";")
        if coding.strip().lower() in ("gzip", "*"):
            return weight.replace(" ", "").lower() not in ("q=0", "q=0.0", "q=0.00", "q=0.000")
    return False


def _has_tag(values: list[str], tag: str) -> bool:
    tags = [each.strip().removeprefix("W/") for each in ",".join(values).split(",")]
    return tag in tags or "*" in tags
