"""The option `-b` of `rostether msg show`: the types of a recording."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rostether.cli.shell.option_group import PATH, add_option
from rostether.errors import DefinitionError, UnknownTypeError

if TYPE_CHECKING:
    from rostether.msgdef.registry import Registry


def bag_option(group: str) -> Callable[[Any], Any]:
    """Return the option for `msg`; `srv` has none, because recordings have no services."""
    if group == "srv":
        return lambda show: show
    return add_option("-b --bag FILE", "Show a type of this recording, in its ROS 1 form.", type=PATH)


def recorded_registry(recording: Path, name: str) -> Registry:
    """Return the types of a recording's topics, as their publishers defined them.

    Raises RecordingError, ConfigError if an extra is missing, UnknownTypeError if the recording lacks the
    type `name`, and DefinitionError if its definition is invalid; those of other types may be invalid.
    """
    from rostether.msgdef.registry import Registry
    from rostether.recording.files import open_recording

    registry = Registry(bundled=False)
    faults: dict[str, DefinitionError] = {}
    with closing(open_recording(recording)) as reader:
        for connection in reader.counts:
            try:
                registry.add_full_text(connection.type.name, connection.type.definition)
            except DefinitionError as error:
                faults[connection.type.name] = error
    for each, fault in faults.items():
        if name in (each, each.partition("/")[2]):
            raise fault
    known = registry.messages()
    if name not in (*known, *(each.partition("/")[2] for each in known)):
        raise UnknownTypeError(
            f"{recording} has no type {name}; `rostether bag info {recording}` lists the types of its topics"
        )
    return registry
