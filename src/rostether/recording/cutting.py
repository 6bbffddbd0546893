"""Cuts a span of time out of many recordings, such as the rotated recordings of one robot."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import ExitStack, closing
from datetime import datetime, timedelta
from functools import partial
from itertools import chain
from pathlib import Path

from rostether.errors import ConfigError, RecordingError
from rostether.recording.file_lock import ACTIVE_SUFFIX
from rostether.recording.files import FILE_SUFFIXES, Form, create_recording, form_for, form_of, open_recording
from rostether.recording.recorded import Wanted, merged
from rostether.recording.reindexing import refuse_same, write_messages
from rostether.rostime import NS_PER_S

# The limit of recordings to search: a week of recordings of ten minutes.
MAX_RECORDINGS = 1008
# The limit of open recordings, one for each sensor: a process may open 1024 files.
MAX_OVERLAPPING = 200

_SUFFIXES = (*FILE_SUFFIXES, ACTIVE_SUFFIX)
_CLOCK = re.compile(r"(?:(\d{4}-\d\d-\d\d)[T ])?(\d{1,2}:\d\d(?::\d\d(?:\.\d{1,6})?)?)(Z|[+-]\d\d:?\d\d)?")


def find_recordings(paths: Sequence[Path]) -> list[Path]:
    """Return the given files, and the recordings in folders and in their folders, such as one for each robot.

    Raises ConfigError if there are none, or too many.
    """
    found: list[Path] = []
    for path in paths:
        if not _is_folder(path):
            found.append(path)
            continue
        for inside in sorted(path.iterdir()):
            deeper = sorted(inside.iterdir()) if _is_folder(inside) else (inside,)
            found += [each for each in deeper if _is_recording(each)]
    if not found:
        raise ConfigError(f"no recordings in {', '.join(map(str, paths))}; give recordings or their folder")
    if len(found) > MAX_RECORDINGS:
        raise ConfigError(f"{len(found)} recordings; at most {MAX_RECORDINGS} are searched; give fewer")
    return found


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not (path / "metadata.yaml").exists()


def _is_recording(path: Path) -> bool:
    return (path.suffix in _SUFFIXES and not _is_folder(path)) or (path / "metadata.yaml").exists()


def moment_ns(text: str, last_ns: int) -> int:
    """Return a local time such as 14:02, 14:02:30 or 2026-11-23 14:02 in nanoseconds since the epoch.

    Without a date, it is the last such time before `last_ns`. With an offset such as +01:00 or Z, the time is
    not local. Raises ConfigError.
    """
    found = _CLOCK.fullmatch(text.strip())
    last = datetime.fromtimestamp(last_ns // NS_PER_S).astimezone()
    try:
        if found is None:
            raise ValueError(text)
        date, clock, offset = found.groups()
        clock = clock.zfill(len(clock) + (clock.index(":") == 1))
        moment = datetime.fromisoformat(f"{date or last.date().isoformat()}T{clock}{offset or ''}")
    except (ValueError, OverflowError):
        raise ConfigError(f"{text!r:.100} is not a time; write 14:02, 14:02:30 or 2026-11-23 14:02") from None
    if not date and moment.astimezone() > last:
        moment -= timedelta(days=1)
    return int(moment.timestamp()) * NS_PER_S + moment.microsecond * 1000


def second_moment(text: str, start_ns: int) -> str:
    """Return the second moment of a local time that occurs twice when clocks are set back, otherwise "".

    `start_ns` is the first moment. A `text` with an offset has only one.
    """
    found = _CLOCK.fullmatch(text.strip())
    if found is None or found[3]:
        return ""
    first = datetime.fromtimestamp(start_ns // NS_PER_S)
    second = first.replace(fold=1)
    return str(second.astimezone()) if second.timestamp() > first.timestamp() else ""


class Cutting:
    """The recordings to cut from; only those that overlap the span are open at the same time."""

    def __init__(self, paths: Sequence[Path]) -> None:
        """Read the time spans of the recordings. Raises RecordingError if none of them has a message."""
        self._spans: dict[Path, tuple[int, int]] = {}
        # Recordings that cannot be read, and why: one damaged file must not hide the others.
        self.unreadable: dict[Path, str] = {}
        # Recordings of which only a part can be read, and why; those in progress have no index yet.
        self.damage: dict[Path, str] = {}
        self.topics: set[str] = set()
        for path in paths:
            try:
                with closing(open_recording(path)) as reader:
                    self.topics |= {each.topic for each in reader.counts}
                    if reader.damage and path.suffix != ACTIVE_SUFFIX:
                        self.damage[path] = reader.damage
                    if reader.span_ns is not None:
                        self._spans[path] = reader.span_ns
            except RecordingError as error:
                self.unreadable[path] = str(error)
        if not self._spans:
            raise RecordingError(next(iter(self.unreadable.values()), "the recordings have no messages"))

    @property
    def span_ns(self) -> tuple[int, int]:
        """The times of the first and the last message of all recordings."""
        return min(first for first, _ in self._spans.values()), max(last for _, last in self._spans.values())

    def write(self, target: Path, wanted: Wanted, start_ns: int, end_ns: int) -> tuple[int, int]:
        """Write the messages of a span to a new recording, in the order of their times.

        Returns the numbers of messages and of recordings; writes no file if there are no messages. Raises
        ConfigError, and RecordingError; then no file remains.
        """
        chosen = [path for path, span in self._spans.items() if span[0] <= end_ns and span[1] >= start_ns]
        if len(chosen) > MAX_OVERLAPPING:
            raise RecordingError(
                f"{len(chosen)} recordings are in this time; at most {MAX_OVERLAPPING} are allowed; give "
                "fewer, or a shorter time"
            )
        for path in chosen:
            refuse_same(path, target)
        if not chosen:
            return 0, 0
        with ExitStack() as opened:
            with closing(open_recording(chosen[0])) as first_reader:
                form = form_for(target, form_of(first_reader))
            # ROS 2 messages are copied unchanged, unless the new recording is a ROS 1 recording.
            is_native = form is Form.ROS2
            readers = [
                opened.enter_context(closing(open_recording(each, is_native=is_native))) for each in chosen
            ]
            messages = merged(readers, wanted, start_ns=start_ns, end_ns=end_ns)
            first = next(messages, None)
            if first is None:
                return 0, 0
            count = write_messages(chain((first,), messages), target, partial(create_recording, form=form))
        return count, len(chosen)
