"""Opens recordings (bags, MCAP files, ROS 2 bags), and detects their format by name and first bytes."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from datetime import datetime
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.errors import ConfigError
from rostether.recording.bag.reader import BagReader
from rostether.recording.bag.records import MAGIC
from rostether.recording.bag.writer import BagWriter
from rostether.recording.chunked_writer import DEFAULT_CHUNK_BYTES
from rostether.recording.compression import NONE
from rostether.recording.file_lock import ACTIVE_SUFFIX, FileLock
from rostether.recording.recorded import RecordingReader, RecordingWriter
from rostether.recording.regular_file import SQLITE_MAGIC, require_regular_file

if TYPE_CHECKING:
    from rostether.recording.ros2.channels import UnfitMessages
    from rostether.ros2.types.type_support import Ros2Types

BAG_SUFFIX = ".bag"
MCAP_SUFFIX = ".mcap"
DB3_SUFFIX = ".db3"
FILE_SUFFIXES = (BAG_SUFFIX, MCAP_SUFFIX, DB3_SUFFIX)
MCAP_MAGIC = b"\x89MCAP"


class Form(StrEnum):
    """The form of the messages in a recording: of ROS 1, or of ROS 2."""

    ROS1 = "ros1"
    ROS2 = "ros2"


def dated_name() -> str:
    """Return the local time as rosbag writes it in the names of files."""
    return datetime.now().astimezone().strftime("%Y-%m-%d-%H-%M-%S")


def open_recording(path: Path, *, is_native: bool = False, damage: str = "") -> RecordingReader:
    """Open a recording for reading.

    ROS 2 messages are returned as ROS 1 bytes, with the fields of the ROS 1 type. With `is_native`, they have
    the fields of the ROS 2 type. `damage` is the reason why the index of a file is invalid. Raises
    RecordingError, and ConfigError if an extra is missing.
    """
    if path.is_dir() or path.name == "metadata.yaml":
        from rostether.recording.ros2.bag_reader import Ros2BagReader

        return Ros2BagReader(path if path.is_dir() else path.parent, is_native=is_native, damage=damage)
    require_regular_file(path)
    # The error for a file with unknown first bytes depends on its suffix.
    extension = "" if is_bag(path) else Path(path.name.removesuffix(ACTIVE_SUFFIX)).suffix
    if is_mcap(path) or (extension == MCAP_SUFFIX and not _begins_with(path, SQLITE_MAGIC)):
        from rostether.recording.mcap.reader import McapReader

        return McapReader(path, is_native=is_native, damage=damage)
    if _begins_with(path, SQLITE_MAGIC) or extension == DB3_SUFFIX:
        from rostether.recording.ros2.db3_reader import Db3Reader

        return Db3Reader(path, is_native=is_native)
    return BagReader(path, damage=damage)


def form_of(reader: RecordingReader) -> Form:
    """Return the form of a recording's messages."""
    return Form.ROS2 if any(each.origin is not None for each in reader.counts) else Form.ROS1


def form_for(path: Path, source: Form, requested: Form | None = None) -> Form:
    """Return the form of a new recording: the requested one, else that of its name or its source.

    Raises ConfigError if a recording with this name cannot have the requested form.
    """
    name = path.name.removesuffix(ACTIVE_SUFFIX)
    if name.endswith((BAG_SUFFIX, ".bag.orig")):
        if requested is Form.ROS2:
            raise ConfigError(
                f"{path}: a .bag file can contain only ROS 1 messages; give a folder, or a .mcap or .db3 file"
            )
        return Form.ROS1
    if name.endswith(MCAP_SUFFIX):
        return requested or source
    if requested is Form.ROS1:
        raise ConfigError(f"{path}: a ROS 1 recording must be a .bag or .mcap file")
    return Form.ROS2


def create_recording(
    path: Path,
    *,
    compression: str = NONE,
    chunk_bytes: int = DEFAULT_CHUNK_BYTES,
    form: Form = Form.ROS1,
    types: Ros2Types | None = None,
    unfit: UnfitMessages | None = None,
    storage: str = "mcap",
) -> RecordingWriter:
    """Create a recording, or overwrite one.

    `types` replaces the types of the environment; `unfit` counts messages that do not fit their type. A name
    without a suffix creates a folder, a ROS 2 bag; `storage` (mcap or sqlite3) is the format of its file.
    Raises RecordingError, ConfigError.
    """
    name = path.name.removesuffix(ACTIVE_SUFFIX)
    if name.endswith(MCAP_SUFFIX):
        if form is Form.ROS2:
            from rostether.recording.ros2.mcap_writer import Ros2McapWriter

            return Ros2McapWriter(
                path, compression=compression, chunk_bytes=chunk_bytes, types=types, unfit=unfit
            )
        from rostether.recording.mcap.writer import McapWriter

        return McapWriter(path, compression=compression, chunk_bytes=chunk_bytes)
    if name.endswith((BAG_SUFFIX, ".bag.orig")):
        return BagWriter(path, compression=compression, chunk_bytes=chunk_bytes)
    if compression != NONE and (name.endswith(DB3_SUFFIX) or storage != "mcap"):
        raise ConfigError(".db3 files cannot be compressed; use MCAP, or no compression")
    if name.endswith(DB3_SUFFIX):
        from rostether.recording.ros2.db3_writer import Db3Writer

        return Db3Writer(path, types=types, unfit=unfit)
    if form is Form.ROS1 or path.suffix[1:].isalpha():
        raise ConfigError(
            f"{path}: the name of a recording must end with .bag, .mcap or .db3; "
            "only a ROS 2 bag, a folder, has no suffix"
        )
    from rostether.recording.ros2.bag_writer import Ros2Bag

    bag = Ros2Bag(path, storage, compression=compression, chunk_bytes=chunk_bytes, types=types, unfit=unfit)
    return bag.create(bag.path_of(0))


def locked(path: Path) -> AbstractContextManager[object]:
    """Lock a recording while the block writes it.

    Raises RecordingError. A ROS 2 bag needs no lock: its folder must be empty at the start.
    """
    is_file = path.name.removesuffix(ACTIVE_SUFFIX).endswith(FILE_SUFFIXES)
    return FileLock(path) if is_file else nullcontext()


def is_mcap(path: Path) -> bool:
    """Return whether a file starts like MCAP; False if it cannot be read."""
    return _begins_with(path, MCAP_MAGIC)


def is_bag(path: Path) -> bool:
    """Return whether a file starts like a ROS 1 bag; False if it cannot be read."""
    return _begins_with(path, MAGIC)


def _begins_with(path: Path, magic: bytes) -> bool:
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return file.read(len(magic)) == magic
    except OSError:
        return False
