"""`rostether firmware`: the client library and the sketches that use it."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_VERBS = {
    "build": VerbEntry("rostether.cli.firmware.build:firmware_build", "Build a sketch."),
    "size": VerbEntry(
        "rostether.cli.firmware.size:firmware_size", "Show how much of the board's memory a sketch uses."
    ),
    "sim": VerbEntry(
        "rostether.cli.firmware.sim:firmware_sim", "Build a sketch and run it on a simulated board."
    ),
    "upload": VerbEntry("rostether.cli.firmware.upload:firmware_upload", "Build a sketch and flash a board."),
    "lib": VerbEntry("rostether.cli.firmware.lib:firmware_lib", "Generate the C++ client library, ros_lib."),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether firmware size blink.ino --board uno                will it fit?
    rostether firmware upload blink.ino --board uno              build and flash
    rostether firmware lib ~/Arduino/libraries                   the library for the Arduino IDE
    """,
)
def firmware() -> None:
    """Build sketches for boards, and generate the C++ client library that they use."""
