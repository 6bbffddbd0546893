"""The files of recordings (names, ROS version, compression), and the node that records or replays."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click
from msgspec import Struct

from rostether.cli.access.graph_options import GraphOptions, Middleware
from rostether.cli.shell.option_group import add_option
from rostether.cli.shell.output import warn
from rostether.errors import ConfigError
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach

if TYPE_CHECKING:
    from rostether.graph.ports import Graph
    from rostether.recording.files import Form
    from rostether.recording.recorded import RecordingReader, Ros2Origin
    from rostether.ros2.types.type_support import Ros2Types

format_option = add_option(
    "--format form",
    "The ROS version of the messages (default: that of the graph or of the source).",
    type=click.Choice(["ros1", "ros2"]),
)
storage_option = add_option(
    "--storage",
    "The file format in a ROS 2 bag's folder (default: mcap).",
    type=click.Choice(["mcap", "sqlite3"]),
    default="mcap",
)


def create_folder(folder: Path) -> None:
    """Create a folder, unless it exists. Raises ConfigError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(
            f"cannot create the folder {folder}: {error.strerror or error}; choose another folder"
        ) from None


def warn_of_damage(path: Path, damage: str) -> None:
    """Warn that messages may be missing, unless `damage` is empty."""
    if damage:
        warn(f"{path}: {damage}; only its complete part is read")


def asked_form(typed: str | None) -> Form | None:
    """Return the form of messages that `--format` selects, None if it was not given."""
    from rostether.recording.files import Form

    return None if typed is None else Form(typed)


def open_for(source: Path, target: Path, asked: Form | None = None) -> tuple[RecordingReader, Form]:
    """Open a recording to copy it to `target`; return its reader and the form of the messages to write.

    From ROS 2 to ROS 2, messages keep ROS 2's own fields. Raises RecordingError, ConfigError.
    """
    from rostether.recording.files import Form, form_for, form_of, open_recording

    reader = open_recording(source)
    try:
        form = form_for(target, form_of(reader), asked)
        is_native = form is Form.ROS2 and form_of(reader) is Form.ROS2
    except BaseException:
        reader.close()
        raise
    if is_native:
        reader.close()
        reader = open_recording(source, is_native=True)
    return reader, form


def new_path(name: str | None, prefix: str | None, source: Form, asked: Form | None) -> tuple[Path, Form]:
    """Return the path and the form of a new recording, named like those of rosbag and rosbag2.

    `source` is the form of the graph, and `asked` that of `--format`. A path without the suffix of a file is
    the folder of a ROS 2 bag. Raises ConfigError.
    """
    from rostether.recording.files import BAG_SUFFIX, FILE_SUFFIXES, Form, dated_name, form_for

    wanted = asked or source
    if name is None:
        begin = f"{prefix.removesuffix(BAG_SUFFIX)}_" if prefix else ""
        name = f"{begin or ('rosbag2_' if wanted is Form.ROS2 else '')}{dated_name()}"
    path = Path(name)
    if not path.name:
        raise ConfigError(f"{path} is a folder; give the name of a new file or folder in it")
    if path.suffix not in FILE_SUFFIXES and wanted is Form.ROS1:
        path = path.with_name(path.name + BAG_SUFFIX)
    return path, form_for(path, source, asked)


def check_compression(path: Path, compression: str, storage: str) -> None:
    """Raise ConfigError for options that would fail only when the file is created."""
    if compression == "none" or path.suffix == ".bag":
        return
    if path.suffix == ".db3" or (path.suffix != ".mcap" and storage != "mcap"):
        raise ConfigError(".db3 files cannot be compressed; use MCAP, or no compression")
    if compression == "bz2":
        raise ConfigError("MCAP does not support bz2; use --lz4, or no compression")


class RecordingGraph(Struct, frozen=True):
    """The node of this command; `types` are its ROS 2 types, None on ROS 1 alone."""

    raw: Graph
    types: Ros2Types | None


@asynccontextmanager
async def recording_graph(
    graph: GraphOptions,
    purpose: str,
    *,
    is_native: bool = False,
    origins: Iterable[Ros2Origin] = (),
    msg_paths: Iterable[Path] = (),
) -> AsyncIterator[RecordingGraph]:
    """Run a node until the end of the block; its name begins with `purpose`.

    If `is_native`, messages on ROS 2 alone have ROS 2's own fields. `origins` are the types in recordings,
    whose definitions need not be installed. Raises GraphError, ConfigError, InvalidNameError.
    """
    # Commands that only read and write files start much faster without these modules.
    from rostether.cli.access.ros1_access import joined, read_environment, ros1_join
    from rostether.cli.access.ros2_access import ros2_access
    from rostether.mechanisms.block_end import closed_at_end

    graph.refuse_unused()
    if graph.ros2 is None:
        async with joined(graph, purpose=purpose) as node:
            yield RecordingGraph(node.raw, None)
        return
    paths = tuple(msg_paths)
    types = recording_types(origins, paths) if is_native and graph.is_ros2_alone else None
    # A recorder must not become the router that other programs need.
    reach = ZenohReach(RouterChoice.NEVER, graph.zenoh.connect, graph.zenoh.listen)
    name = graph.node_name(purpose)
    async with ros2_access(graph.ros2, paths, reach=reach, types=types) as access:
        if graph.ros2 is Middleware.ZENOH and not (reach.connect or reach.listen):
            from rostether.cli.access.ros2_tool_node import warn_without_router

            await warn_without_router()
        join = access.join
        if graph.uses_ros1:
            from rostether.graph.joint_join import JointJoin

            join = JointJoin([ros1_join(read_environment(graph)), join])
        async with closed_at_end(await join(name, namespace=graph.arguments.get("__ns", "/"))) as raw:
            yield RecordingGraph(raw, access.types)


def recording_types(origins: Iterable[Ros2Origin], msg_paths: tuple[Path, ...] = ()) -> Ros2Types:
    """Return the installed and the recorded types with ROS 2's own fields; unknown types remain CDR."""
    from rostether.msgdef.registry import Registry
    from rostether.msgdef.ros2.definitions import Ros2Definitions
    from rostether.recording.ros2_types import RecordedDefinitions
    from rostether.ros2.types.native_registry import NativeRegistry
    from rostether.ros2.types.undefined_types import UndefinedTypes

    definitions = RecordedDefinitions(Ros2Definitions.from_environment(msg_paths))
    for origin in origins:
        definitions.learn(origin)
    return UndefinedTypes(NativeRegistry(definitions, Registry.from_environment(msg_paths)))
