"""Reads a whole recording and lists its errors."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from msgspec import Struct

from rostether.errors import RecordingError, RostetherError, UnknownTypeError
from rostether.mechanisms.text import counted, escape_line, misfit_text
from rostether.msgdef.registry import Registry
from rostether.recording.bag import checking as bag_checking
from rostether.recording.decoding import Decoder
from rostether.recording.files import is_bag, is_mcap, open_recording
from rostether.recording.mcap import checking as mcap_checking
from rostether.recording.recorded import Connection
from rostether.recording.regular_file import MappedFile
from rostether.serde.layout import Layout


class CheckResult(Struct, frozen=True):
    """The number of readable messages, and the errors, one line each."""

    message_count: int
    faults: tuple[str, ...]


def check(path: Path, registry: Registry) -> CheckResult:
    """Read a recording; `registry` has the types known here.

    Raises RecordingError if it is not a recording, and ConfigError if an extra is missing.
    """
    layouts: dict[Connection, Layout] = {}
    decoder = Decoder()
    # By topic: the number of messages that do not fit their type, and the reason for the first one.
    unfit: dict[str, tuple[int, str]] = {}
    count = 0
    with closing(open_recording(path)) as reader:
        faults = [reader.damage + "; `rostether bag reindex` repairs it"] if reader.damage else []
        faults += file_faults(path)
        for connection in reader.counts:
            try:
                layouts[connection] = decoder.codec(connection).layout
            except RostetherError as error:
                faults.append(
                    f"{connection.topic}: its definition of {connection.type.name} is broken: {error}"
                )
                continue
            if connection.origin is None:
                faults.extend(_differences(connection, registry))
        try:
            for message in reader.messages():
                count += 1
                layout = layouts.get(message.connection)
                if layout is not None and not layout.accepts(message.payload):
                    topic = message.connection.topic
                    before, why = unfit.get(topic, (0, ""))
                    unfit[topic] = (before + 1, why or layout.explain(message.payload))
        except RecordingError as error:
            faults.append(str(error))
        faults += [f"{topic}: {why}" for topic, why in reader.unreadable.items()]
        expected = sum(reader.counts.values())
        if count != expected and not faults:
            faults.append(f"its index counts {counted(expected, 'message')}, but the file has {count}")
    faults += [f"{topic}: {misfit_text(many)}: {why}" for topic, (many, why) in unfit.items()]
    # Names in a damaged file may contain anything.
    return CheckResult(count, tuple(dict.fromkeys(escape_line(fault) for fault in faults)))


def file_faults(path: Path) -> list[str]:
    """Return the errors in the records of bags and MCAP files; the types of messages are not checked.

    Raises RecordingError if a file cannot be read.
    """
    if path.is_dir():
        return [
            f"{each.name}: {fault}" for each in sorted(path.glob("*.mcap")) for fault in file_faults(each)
        ]
    if is_mcap(path):
        faults_of = mcap_checking.faults_of
    elif is_bag(path):
        faults_of = bag_checking.faults_of
    else:
        return []
    with closing(MappedFile(path)) as file:
        return faults_of(file.view)


def _differences(connection: Connection, registry: Registry) -> list[str]:
    name, md5sum = connection.type.name, connection.type.md5sum
    try:
        known = registry.message_type(name).md5sum
    except UnknownTypeError:
        return []  # The recording contains its definition.
    except RostetherError as error:
        return [f"{name} is broken here: {error}"]
    if known == md5sum:
        return []
    return [
        f"{name} was recorded with md5sum {md5sum}, but is known as {known}: current nodes cannot read it"
    ]
