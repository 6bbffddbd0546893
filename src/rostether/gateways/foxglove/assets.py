"""Serves files of packages to clients: the meshes and images of a robot description.

It reads only visible files inside packages on this machine, and downloads nothing.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import asynccontextmanager, nullcontext
from pathlib import Path
from urllib.parse import unquote

from rostether.errors import ConfigError
from rostether.mechanisms.text import read_failure

# Maps the packages' names to their folders.
FindPackages = Callable[[], Mapping[str, Path]]

# Most meshes are smaller. Larger ones are in memory for a few clients at a time: 64 would need 1.5 GB.
_LARGE_BYTES = 4 << 20
_LARGE_AT_ONCE = 4


class Assets:
    """Reads the files that clients may see."""

    def __init__(self, find_packages: FindPackages, max_bytes: int) -> None:
        self._find_packages = find_packages
        self._max_bytes = max_bytes
        self._folders: Mapping[str, Path] = {}
        # Clients request all meshes of a robot at the same time: one search serves them.
        self._lock = asyncio.Lock()
        self._large_room = asyncio.Semaphore(_LARGE_AT_ONCE)

    @asynccontextmanager
    async def reading(self, uri: str, head: bytes = b"") -> AsyncIterator[bytes]:
        """Yield `head` and a file's bytes; other clients wait if several large files are in use.

        Raises ConfigError with the reason.
        """
        async with self._lock:
            # Runs in a thread, because packages are searched on disk.
            path, size = await asyncio.to_thread(self._find, uri)
        async with self._large_room if size > _LARGE_BYTES else nullcontext():
            yield await asyncio.to_thread(self._read, uri, path, head)

    def _find(self, uri: str) -> tuple[Path, int]:
        path = self._locate(uri)
        try:
            size = path.stat().st_size
        except OSError as error:
            raise ConfigError(read_failure(uri[:200], error)) from None
        self._check_size(uri, size)
        return path, size

    def _read(self, uri: str, path: Path, head: bytes) -> bytes:
        try:
            with path.open("rb") as file:
                data = file.read(self._max_bytes + 1)
        except OSError as error:
            raise ConfigError(read_failure(uri[:200], error)) from None
        self._check_size(uri, len(data))
        return head + data

    def _check_size(self, uri: str, size: int) -> None:
        if size > self._max_bytes:
            raise ConfigError(
                f"{uri[:200]} is larger than {self._max_bytes >> 20} MiB; "
                "use a mesh or picture with less detail"
            )

    def _locate(self, uri: str) -> Path:
        # Text after ? and # belongs to the name of a file.
        scheme, _, rest = uri.partition("://")
        rest = unquote(rest)
        if "\0" in rest:
            raise ConfigError("the address of a file cannot contain a zero byte; write package://NAME/PATH")
        if scheme.lower() == "package":
            name, _, below = rest.partition("/")
            return self._in_package(uri, name, below)
        if scheme.lower() == "file":
            return self._in_any_package(uri, rest)
        raise ConfigError(
            f"{uri[:200]} is not served; use a package:// or file:// address of a known package (clients "
            "load http addresses themselves)"
        )

    def _in_package(self, uri: str, name: str, below: str) -> Path:
        folder = self._folder(name)
        if folder is None:
            raise ConfigError(
                f"there is no package {name[:80]!r} for {uri[:200]}; give its folder "
                "with --msg-path or ROS_PACKAGE_PATH"
            )
        path = _inside(folder, folder / below)
        if path is None:
            raise ConfigError(
                f"{uri[:200]} is not a visible file of the package {name}; check its path in {folder}"
            )
        return path

    def _in_any_package(self, uri: str, rest: str) -> Path:
        # Addresses with another host or a relative path are not files of this machine.
        text = rest if rest.startswith("/") else "/" + rest.partition("/")[2]
        if rest.startswith(("/", "localhost/")):
            self._folders = self._find_packages()
            for folder in self._folders.values():
                if (path := _inside(folder, Path(text))) is not None:
                    return path
        raise ConfigError(
            f"{uri[:200]} is not a visible file of any known package; give the folder of its package "
            "with --msg-path or ROS_PACKAGE_PATH"
        )

    def _folder(self, name: str) -> Path | None:
        folder = self._folders.get(name)
        if folder is None or not folder.is_dir():
            self._folders = self._find_packages()
            folder = self._folders.get(name)
        return folder


def _inside(folder: Path, path: Path) -> Path | None:
    """Return the path if it leads to a file in the folder, after links and `..` are resolved."""
    try:
        real = path.resolve()
        root = next((root for root in _roots(folder) if real.is_relative_to(root)), None)
        if root is None or not real.is_file():
            return None
    except (OSError, ValueError, RuntimeError):
        return None
    if any(part.startswith(".") for part in real.relative_to(root).parts):
        return None
    return real


def _roots(folder: Path) -> Iterator[Path]:
    yield folder.resolve()
    manifest = folder / "package.xml"
    if manifest.is_symlink():
        # A workspace built with --symlink-install: each installed file is a link to the package's source.
        yield manifest.resolve().parent
