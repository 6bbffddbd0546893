"""The files of a recording: their names, their kind of messages, and their compression."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.errors import ConfigError

if TYPE_CHECKING:
    from rostether.recording.files import Form
    from rostether.recording.recorded import RecordingWriter
    from rostether.recording.ros2.bag_writer import Ros2Bag
    from rostether.recording.ros2.unfit_messages import UnfitMessages
    from rostether.ros2.types.type_support import Ros2Types

_SUFFIXES = (".bag", ".mcap", ".db3")

format_option = click.option(
    "--format",
    "form",
    type=click.Choice(["ros1", "ros2"]),
    help="The ROS version of the messages (default: that of the graph or of the source).",
)
storage_option = click.option(
    "--storage",
    type=click.Choice(["mcap", "sqlite3"]),
    default="mcap",
    help="The file format in a ROS 2 bag's folder (mcap).",
)


def asked_form(typed: str | None) -> Form | None:
    """Return the format of --format."""
    from rostether.recording.files import Form

    return None if typed is None else Form(typed)


@dataclass(frozen=True, slots=True)
class Packing:
    """The compression and the size of chunks, and the file format in a ROS 2 bag's folder."""

    compression: str
    chunk_bytes: int
    storage: str


class NewFiles:
    """The files of one recording, named like those of rosbag and rosbag2. Raises ConfigError.

    `types` and `unfit` are set later, when the graph is known.
    """

    def __init__(
        self,
        name: str | None,
        prefix: str | None,
        packing: Packing,
        asked: Form | None,
        *,
        is_splitting: bool,
        of_ros2_graph: bool,
    ) -> None:
        from rostether.recording.files import Form, form_for

        source = Form.ROS2 if of_ros2_graph else Form.ROS1
        self.types: Ros2Types | None = None
        self.unfit: UnfitMessages | None = None
        self._packing = packing
        self._is_splitting = is_splitting
        self._bag: Ros2Bag | None = None
        if name is None:
            date = datetime.now().astimezone().strftime("%Y-%m-%d-%H-%M-%S")
            name = date if not prefix else f"{prefix.removesuffix('.bag')}_{date}"
            if (asked or source) is Form.ROS2:
                name = f"rosbag2_{name}" if not prefix else name
        path = Path(name)
        suffix = path.suffix if path.suffix in _SUFFIXES else ""
        if not suffix and (asked or source) is Form.ROS1:
            suffix = ".bag"
        self._folder = path.parent
        self._stem = path.name.removesuffix(suffix)
        self._suffix = suffix
        self._form = form_for(path.with_name(self._stem + suffix), source, asked)
        _check_compression(packing, suffix)

    @property
    def is_of_ros2(self) -> bool:
        """Whether the files hold messages of ROS 2."""
        from rostether.recording.files import Form

        return self._form is Form.ROS2

    def path_of(self, number: int) -> Path:
        """Return the path of the file of a number."""
        if not self._suffix:
            return self._ros2_bag().path_of(number)
        stem = f"{self._stem}_{number}" if self._is_splitting else self._stem
        return self._folder / f"{stem}{self._suffix}"

    def create(self, path: Path) -> RecordingWriter:
        """Create a file. Raises RecordingError, ConfigError."""
        if not self._suffix:
            return self._ros2_bag().create(path)
        from rostether.recording.files import create_recording

        return create_recording(
            path,
            compression=self._packing.compression,
            chunk_bytes=self._packing.chunk_bytes,
            form=self._form,
            types=self.types,
            unfit=self.unfit,
        )

    def _ros2_bag(self) -> Ros2Bag:
        if self._bag is None:
            from rostether.recording.ros2.bag_writer import Ros2Bag, Storage

            self._bag = Ros2Bag(
                self._folder / self._stem,
                Storage(self._packing.storage),
                compression=self._packing.compression,
                chunk_bytes=self._packing.chunk_bytes,
                types=self.types,
                unfit=self.unfit,
            )
        return self._bag


def _check_compression(packing: Packing, suffix: str) -> None:
    """Raise ConfigError for options that would fail only when the file is created."""
    if packing.compression == "none" or suffix == ".bag":
        return
    if suffix == ".db3" or (not suffix and packing.storage != "mcap"):
        raise ConfigError(".db3 files cannot be compressed; use MCAP")
    if packing.compression == "bz2":
        raise ConfigError("MCAP does not support bz2; use --lz4, or no compression")
