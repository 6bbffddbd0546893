"""`rostether firmware lib`: the client library with the messages that a sketch needs, or all."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click

from rostether.cli.access.completions import complete_packages
from rostether.cli.access.options import msg_path_option
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import PATH, add_flag, add_option
from rostether.cli.shell.output import json_option, warn, write_result
from rostether.cli.shell.verbs import verb
from rostether.mechanisms.text import counted
from rostether.msgdef.registry import Registry


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
) -> int:
    """Write the client library with messages and services to DIR/ros_lib.

    An older generated library there is replaced; other folders are not changed. The C++ library works with
    Arduino and PlatformIO; other builds need only -I DIR/ros_lib/src. Invalid definitions are reported and
    skipped, and the exit code is then 1.
    """
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
    library = written.library
    for line in (*library.skipped, *library.warnings):
        warn(line)
    record = {
        "path": str(written.path),
        "replaced": written.replaced,
        "types": list(library.types),
        "skipped": list(library.skipped),
        "warnings": list(library.warnings),
    }
    package_count = len({name.partition("/")[0] for name in library.types})
    action = "replaced" if written.replaced else "wrote"
    counts = f"{counted(len(library.types), 'type')} of {counted(package_count, 'package')}"
    write_result(record, f"{action} {written.path}: {counts}", as_json=as_json)
    return EXIT_FAILED if library.skipped else EXIT_DONE


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
