"""`rostether flash`: flashes a sketch to a board, then serves the board."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.firmware.build import upload_sketch
from rostether.cli.firmware.options import build_options, port_option
from rostether.cli.launch.run import replace_process
from rostether.cli.shell.output import write_line
from rostether.cli.shell.own_command import own_command
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb

if TYPE_CHECKING:
    from rostether.firmware.built_firmware import BuildOptions

# The baud rate that a sketch sets.
_BAUD = re.compile(r"\bsetBaud\s*\(\s*([0-9]+)\s*\)")


@verb(
    "flash",
    """
    rostether flash ultrasound                     to the only board plugged in
    rostether flash robot --board mega --port /dev/ttyACM0
    """,
)
@build_options
@port_option
def flash(sketch: Path, board_name: str, options: BuildOptions, port: str | None) -> None:
    """Build a sketch, flash it, and connect the board to the ROS graph until Ctrl-C.

    It combines `rostether firmware upload` and `rostether serve`; the log shows the board's topics.
    """
    chosen = run(upload_sketch(sketch, board_name, options, port))
    address = address_of(sketch, chosen)
    write_line(f"rostether serve {shlex.quote(address)}")
    replace_process(own_command("serve", address), os.environ)


def address_of(sketch: Path, port: str) -> str:
    """Return the link address of a port, with the baud rate that the sketch sets."""
    from rostether.firmware.sketch import open_sketch

    found = open_sketch(sketch)
    for file in (*found.inos, *found.sources):
        if match := _BAUD.search(file.read_text(encoding="utf-8", errors="replace")):
            return f"{port}?baud={match[1]}"
    return port
