"""`rostether firmware lib`: the client library with the messages that a sketch needs, or all."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.completions import complete_packages
from rostether.cli.access.options import msg_path_option
from rostether.cli.shell.failures import EXIT_FAILED
from rostether.cli.shell.option_group import PATH, add_flag, add_option
from rostether.cli.shell.output import json_option, warn, write_result
from rostether.cli.shell.verbs import verb
from rostether.mechanisms.text import counted

if TYPE_CHECKING:
    from rostether.codegen.arduino_library import WrittenLibrary


@verb(
    "lib",
    """
    rostether firmware lib ~/Arduino/libraries                   all messages: for the Arduino IDE
    rostether firmware lib lib --for src/main.cpp                what a PlatformIO project needs
    rostether firmware lib . --package std_msgs --package tf     two packages, with the types of their fields
    rostether firmware lib ~/Arduino/libraries --msg-path ~/my_robot
    rostether firmware lib . --micropython --for main.py         for a board with MicroPython
    """,
)
@click.argument("directory", metavar="DIR", type=PATH)
@add_option(
    "--for sketch SKETCH",
    "Only the messages that this .ino, C++ or Python file, or folder, includes or imports.",
    type=PATH,
)
@add_option(
    "--package --messages packages P",
    "Only this package or type, such as std_msgs or std_msgs/String, and its fields; may be repeated.",
    multiple=True,
    shell_complete=complete_packages,
)
@add_flag(
    "--micropython",
    "Write the library for MicroPython and CircuitPython, to be copied to the board's folder lib.",
)
@msg_path_option
@json_option
def firmware_lib(
    directory: Path,
    sketch: Path | None,
    packages: tuple[str, ...],
    micropython: bool,
    msg_paths: tuple[Path, ...],
    as_json: bool,
) -> None:
    """Write the client library with messages and services to DIR/ros_lib.

    An older generated library there is replaced; other folders are not changed. The C++ library works with
    Arduino and PlatformIO; other builds need only -I DIR/ros_lib/src. Invalid definitions are reported and
    skipped, and the exit code is then 1.
    """
    from rostether.msgdef.registry import Registry

    registry = Registry.from_environment(msg_paths)
    sketch = sketch.expanduser() if sketch is not None else None
    if micropython:
        from rostether.codegen.micropython_library import write_micropython_library

        written = write_micropython_library(
            directory, registry, for_program=sketch, packages=packages or None
        )
    else:
        from rostether.codegen.arduino_library import write_library

        written = write_library(
            directory,
            registry,
            for_sketch=sketch,
            packages=packages or None,
            search=_other_libraries(directory) if sketch is not None else (),
        )
    for line in (*written.library.skipped, *written.library.warnings):
        warn(line)
    write_result(_record(written), _summary(written), as_json=as_json)
    if written.library.skipped:
        raise click.exceptions.Exit(EXIT_FAILED)


def _other_libraries(directory: Path) -> Iterator[Path]:
    """Yield the header folders of the other libraries: a sketch may include messages through them."""
    from rostether.codegen.arduino_library import LIBRARY_NAME

    directory = directory.expanduser()
    if not directory.is_dir():
        return
    for library in sorted(directory.iterdir()):
        if library.name == LIBRARY_NAME or library.name.startswith(".") or not library.is_dir():
            continue
        sources = library / "src"
        yield sources if sources.is_dir() else library


def _summary(written: WrittenLibrary) -> str:
    types = written.library.types
    packages = {name.partition("/")[0] for name in types}
    action = "replaced" if written.replaced else "wrote"
    return f"{action} {written.path}: {counted(len(types), 'type')} of {counted(len(packages), 'package')}"


def _record(written: WrittenLibrary) -> dict[str, object]:
    return {
        "path": str(written.path),
        "replaced": written.replaced,
        "types": list(written.library.types),
        "skipped": list(written.library.skipped),
        "warnings": list(written.library.warnings),
    }
