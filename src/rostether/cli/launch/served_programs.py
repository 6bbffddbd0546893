"""Built-in programs that launch files run for a parameter's value: `$(find xacro)/xacro`."""

from __future__ import annotations

from rostether.cli.launch.served_nodes import our_command

_PROGRAMS = {("xacro", "xacro"): ("xacro",)}


def served_programs() -> dict[tuple[str, str], list[str]]:
    """Map (package, program) to whole command lines, without the program's arguments."""
    return {program: our_command(*words) for program, words in _PROGRAMS.items()}
