"""`rostether firmware`: the client library and the sketches that use it."""

from __future__ import annotations

import click

from rostether.cli.verbs import LazyGroup, VerbEntry

_VERBS = {
    "lib": VerbEntry("rostether.cli.firmware_lib:firmware_lib", "Generate the C++ client library, ros_lib."),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether firmware lib ~/Arduino/libraries
    """,
)
def firmware() -> None:
    """Make what runs on boards: the client library for Arduino, PlatformIO and others."""
