"""Makes the command of a node: arguments, environment and working folder."""

from __future__ import annotations

import contextlib
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias

from msgspec import Struct, field

from rostether.errors import ConfigError
from rostether.launch.plan import LaunchNode, WorkingFolder

_LATEST = "latest"


class Program(Struct, frozen=True):
    """The command of a package's node, and the environment variables that it needs."""

    words: list[str]
    environ: dict[str, str] = field(default_factory=dict)


class Replaced(Struct, frozen=True):
    """A program that is not started, because a view of the dashboard replaces it; `line` reports this."""

    line: str


# Gets a node's package, type and environment, and returns its program. Raises RostetherError if none exists.
Locate: TypeAlias = Callable[[str, str, Mapping[str, str]], Program | Replaced]


class NodeCommand(Struct, frozen=True):
    """A process to start."""

    words: list[str]
    environ: dict[str, str]
    folder: Path


def node_environment(node: LaunchNode, environ: Mapping[str, str], master_uri: str) -> dict[str, str]:
    """Return a node's environment: that of the caller, with the master, the namespace and the <env> tags."""
    variables = {name: value for name, value in environ.items() if name != "ROS_NAMESPACE"}
    variables["ROS_MASTER_URI"] = master_uri
    if node.namespace != "/":
        variables["ROS_NAMESPACE"] = node.namespace
    return variables | dict(node.environment)


def command_of(
    node: LaunchNode, environ: Mapping[str, str], master_uri: str, locate: Locate
) -> NodeCommand | Replaced:
    """Return a node's command, without the arguments that the runner adds. Raises the errors of `locate`."""
    variables = node_environment(node, environ, master_uri)
    program = locate(node.package, node.type, variables)
    if isinstance(program, Replaced):
        return program
    words = [*shlex.split(node.launch_prefix), *program.words, *node.arguments]
    if node.working_folder is WorkingFolder.NODE:
        # A script comes after its interpreter.
        files = (Path(word) for word in reversed(program.words) if Path(word).is_absolute())
        folder = next(files, Path(program.words[0])).parent
    else:
        folder = ros_home(environ)
    return NodeCommand(words, variables | program.environ, folder)


def ros_home(environ: Mapping[str, str]) -> Path:
    """Return the default working directory of nodes."""
    return Path(environ["ROS_HOME"]) if environ.get("ROS_HOME") else Path.home() / ".ros"


def log_folder(environ: Mapping[str, str], run_id: str) -> Path:
    """Create and return the log folder of a run; the link `latest` next to it then points to it.

    Raises ConfigError if the folder cannot be created.
    """
    parent = Path(environ["ROS_LOG_DIR"]) if environ.get("ROS_LOG_DIR") else ros_home(environ) / "log"
    # The id comes from a master: it must not point outside the folder.
    folder = parent.absolute() / run_id.replace("/", "-").strip(".")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(
            f"cannot create {folder}: {error.strerror}; set ROS_LOG_DIR to another folder"
        ) from None
    latest = parent / _LATEST
    with contextlib.suppress(OSError):
        if latest.is_symlink() or not latest.exists():
            latest.unlink(missing_ok=True)
            latest.symlink_to(folder)
    return folder
