"""The commands of ROS 1 under their own names: small scripts in a folder that `rostether env` puts on PATH.

    name in the shell -> words behind `rostether`

A script is written for the Python that runs us. It never stands before a real ROS on PATH, unless asked to.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shlex
import tempfile
from pathlib import Path

from rostether.cli.launch.served_nodes import our_command
from rostether.errors import ConfigError

SHIM_MARK = "rostether env made this"

SHIMS = {
    "roscore": ("core",),
    "rosrun": ("run",),
    # As it is printed in a magazine that many start with.
    "rossrun": ("run",),
    "roslaunch": ("launch",),
    "rostopic": ("topic",),
    "rosnode": ("node",),
    "rosservice": ("service",),
    "rosparam": ("param",),
    "rosmsg": ("msg",),
    "rossrv": ("srv",),
    "rosbag": ("bag",),
    "rospack": ("pkg",),
    "rosversion": ("pkg", "version"),
    "catkin_create_pkg": ("pkg", "create"),
    "catkin_init_workspace": ("pkg", "init-workspace"),
    "catkin_make": ("pkg", "make"),
    "check_urdf": ("urdf", "check"),
    "rqt_graph": ("graph",),
    "rqt_plot": ("role", "rqt-plot"),
    "rviz": ("run", "rviz", "rviz"),
}


def available_shims() -> dict[str, tuple[str, ...]]:
    """Return the shims whose verb there is."""
    from rostether.cli.verb_table import VERBS

    return {name: words for name, words in SHIMS.items() if words[0] in VERBS}


def write_shims(folder: Path | None = None) -> Path:
    """Write the scripts that are missing or outdated, and return their folder. Raises ConfigError."""
    shims = available_shims()
    texts = {name: _script(words) for name, words in shims.items()}
    folder = folder or _folder("".join(texts[name] for name in sorted(texts)))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            _write(folder / name, text)
    except OSError as error:
        raise ConfigError(
            f"{error.filename or folder}: {error.strerror}; name another cache folder with XDG_CACHE_HOME"
        ) from error
    return folder


def _folder(content: str) -> Path:
    # One folder for each installation and version: shells that are open keep theirs.
    cache = os.environ.get("XDG_CACHE_HOME", "")
    parent = Path(cache) if Path(cache).is_absolute() else Path.home() / ".cache"
    return parent / "rostether" / f"shims-{hashlib.sha256(content.encode()).hexdigest()[:12]}"


def _script(words: tuple[str, ...]) -> str:
    return f'#!/bin/sh\n# {SHIM_MARK}\nexec {shlex.join(our_command(*words))} "$@"\n'


def _write(file: Path, text: str) -> None:
    with contextlib.suppress(OSError):
        if file.read_text() == text and os.access(file, os.X_OK):
            return
    # Another shell may be starting it right now: it must never be there half.
    descriptor, unfinished = tempfile.mkstemp(dir=file.parent)
    with os.fdopen(descriptor, "w") as stream:
        stream.write(text)
    Path(unfinished).chmod(0o755)
    Path(unfinished).replace(file)


def real_ros_commands(environ_path: str, ours: Path) -> dict[str, Path]:
    """Return the commands among the shims' names that are on PATH and not shims, with where they are."""
    found: dict[str, Path] = {}
    for name in available_shims():
        for part in environ_path.split(os.pathsep):
            program = Path(part) / name
            if part and program.parent != ours and os.access(program, os.X_OK) and not is_shim(program):
                found.setdefault(name, program)
    return found


def is_shim(program: Path) -> bool:
    """Tell whether a program is one of these scripts."""
    try:
        with program.open("rb") as stream:
            return SHIM_MARK.encode() in stream.read(200)
    except OSError:
        return False
