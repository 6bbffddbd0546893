"""metadata.yaml, which lists the content of the files of a ROS 2 bag.

It is written in version 9, the version of Jazzy. Source: rosbag2_storage's yaml.hpp.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

import yaml
from msgspec import Struct

from rostether.bounded_yaml import load
from rostether.errors import RecordingError
from rostether.mechanisms.text import first_line, read_failure
from rostether.mechanisms.whole_file import write_whole
from rostether.recording.recorded import Ros2Origin
from rostether.recording.regular_file import require_regular_file
from rostether.recording.ros2_qos import read_profiles
from rostether.recording.write_errors import writing

FILE_NAME = "metadata.yaml"
VERSION = 9
# The metadata of a thousand topics in a thousand files takes 1 MB.
MAX_BYTES = 16 << 20
# Recordings of ten minutes reach this number after two years.
MAX_FILES = 100_000

ValueT = TypeVar("ValueT")

_KEY = "rosbag2_bagfile_information"

# The start time that rosbag2 writes for a bag without messages.
_NO_TIME = 9223372036854775807


class FileFacts(Struct, frozen=True):
    """The contents of one file; `start_ns` is None without messages.

    `topics` has a description and the number of messages by topic and type.
    """

    name: str
    start_ns: int | None
    end_ns: int
    topics: Mapping[tuple[str, str], tuple[Ros2Origin, int]]

    @property
    def message_count(self) -> int:
        """How many messages the file has."""
        return sum(count for _, count in self.topics.values())


class Metadata(Struct, frozen=True):
    """The content of metadata.yaml."""

    version: int
    storage: str
    files: tuple[str, ...]
    compression_format: str = ""
    compression_mode: str = ""


def describe(files: Sequence[FileFacts], storage: str, distro: str) -> dict[str, Any]:
    """Return the content for files in the order of their numbers."""
    topics: dict[tuple[str, str], tuple[Ros2Origin, int]] = {}
    for file in files:
        for key, (origin, count) in file.topics.items():
            topics[key] = (origin, topics.get(key, (origin, 0))[1] + count)
    start_ns = min((each.start_ns for each in files if each.start_ns is not None), default=None)
    end_ns = max((each.end_ns for each in files), default=0)
    return {
        "version": VERSION,
        "storage_identifier": storage,
        "duration": {"nanoseconds": _duration(start_ns, end_ns)},
        "starting_time": {"nanoseconds_since_epoch": _NO_TIME if start_ns is None else start_ns},
        "message_count": sum(each.message_count for each in files),
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic,
                    "type": type_name,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": read_profiles(origin.qos),
                    "type_description_hash": origin.type_hash,
                },
                "message_count": count,
            }
            for (topic, type_name), (origin, count) in topics.items()
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [each.name for each in files],
        "files": [
            {
                "path": each.name,
                "starting_time": {
                    "nanoseconds_since_epoch": _NO_TIME if each.start_ns is None else each.start_ns
                },
                "duration": {"nanoseconds": _duration(each.start_ns, each.end_ns)},
                "message_count": each.message_count,
            }
            for each in files
        ],
        "custom_data": None,
        "ros_distro": distro,
    }


def write_metadata(folder: Path, content: Mapping[str, Any]) -> None:
    """Write metadata.yaml atomically. Raises RecordingError."""
    path = folder / FILE_NAME
    with writing(path):
        write_whole(path, yaml.safe_dump({_KEY: dict(content)}, sort_keys=False).encode())


def read_metadata(folder: Path) -> Metadata:
    """Read metadata.yaml. Raises RecordingError if it is missing or broken."""
    path = folder / FILE_NAME
    require_regular_file(path)
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise RecordingError(read_failure(path, error)) from None
    if len(data) > MAX_BYTES:
        raise RecordingError(f"{path} has more than {MAX_BYTES} bytes")
    try:
        content = load(data.decode("utf-8", "replace"))[_KEY]
        # Before version 4, paths start with the folder's own name; files in other folders are never read.
        files = tuple(
            PurePosixPath(_checked(each, str)).name for each in content["relative_file_paths"][:MAX_FILES]
        )
        return Metadata(
            _checked(content["version"], int),
            _checked(content["storage_identifier"], str),
            files,
            _checked(content.get("compression_format") or "", str),
            _checked(content.get("compression_mode") or "", str).lower().replace("none", ""),
        )
    except KeyError as error:
        reason = f"it has no {error.args[0]}"
    except (LookupError, TypeError, AttributeError):
        reason = "its structure is not that of rosbag2"
    except ValueError as error:
        reason = first_line(error)
    raise RecordingError(f"{path} does not describe a ROS 2 bag: {reason}")


def _checked(value: object, kind: type[ValueT]) -> ValueT:
    # With aliases, a small file can contain huge lists, which are harmless as long as they are not written
    # out.
    if not isinstance(value, kind):
        raise TypeError
    return value


def _duration(start_ns: int | None, end_ns: int) -> int:
    return 0 if start_ns is None else end_ns - start_ns
