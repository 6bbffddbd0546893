"""`rostether new`: writes the first sketch for a sensor."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from rostether.cli.shell.completion import beginning
from rostether.cli.shell.option_group import PATH, add_option
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import verb, verb_group
from rostether.codegen.library_source import client_library
from rostether.errors import ConfigError
from rostether.firmware.new_sketch import KINDS, write_sketch
from rostether.mechanisms.text import did_you_mean

new = verb_group(
    "new",
    "Write a new sketch.",
    {"sensor": ("new:new_sensor", "Write the sketch of a sensor.")},
    "rostether new sensor ultrasound",
    package="rostether.cli.firmware",
)


def _complete_kinds(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    return beginning(KINDS, incomplete)


@verb(
    "sensor",
    """
    rostether new sensor                                   asks for the sensor, its pins and its topic
    rostether new sensor ultrasound
    rostether new sensor ultrasound front --pin TRIG=3 --pin ECHO=4 --topic front/range
    rostether new sensor temperature --pin SENSOR=A2 --board mega
    """,
)
@click.argument("kind", required=False, metavar="[SENSOR]", shell_complete=_complete_kinds)
@click.argument("name", required=False, metavar="[NAME]")
@add_option(
    "--pin pins NAME=PIN",
    "Use another pin; may be repeated. A sensor with one pin needs no NAME.",
    multiple=True,
)
@add_option("--topic TOPIC", "The topic (default: the sensor's).")
@add_option("--board", "The board of the printed flash command.", default="uno", show_default=True)
@add_option(
    "-o --output DIR", "The folder for the sketch's folder (default: this one).", type=PATH, default=Path()
)
def new_sensor(
    kind: str | None, name: str | None, pins: tuple[str, ...], topic: str | None, board: str, output: Path
) -> None:
    """Write a sketch that publishes a sensor: ultrasound, infrared, temperature or button.

    NAME is the name of the sketch (default: the sensor's name). On a terminal, the command asks for a missing
    SENSOR.
    """
    sole = "" if kind not in KINDS or len(KINDS[kind].pins) > 1 else next(iter(KINDS[kind].pins))
    chosen = dict(_read_pin(each, sole) for each in pins)
    if kind is None:
        if not sys.stdin.isatty():
            raise click.UsageError(f"name a sensor: {', '.join(KINDS)}")
        for each, described in KINDS.items():
            write_line(f"  {each:<12} {described.summary}")
        kind = click.prompt("Sensor", type=click.Choice(list(KINDS)), show_choices=False)
        for pin, default in KINDS[kind].pins.items():
            chosen.setdefault(pin, click.prompt(f"Pin of {pin}", default=default))
        topic = topic or click.prompt("Topic", default=KINDS[kind].topic)
    if kind not in KINDS:
        hint = did_you_mean(kind, KINDS) or f"there are {', '.join(KINDS)}"
        raise ConfigError(f"no sensor {kind!r}; {hint}")
    described = KINDS[kind]
    topic = topic or described.topic
    file = write_sketch(output / (name or kind), described, client_library() / "examples", chosen, topic)
    write_line(f"wrote {file}; its first lines show the wiring")
    write_line(f"next: rostether flash {file.parent} --board {board}")


def _read_pin(text: str, sole: str) -> tuple[str, str]:
    """Return a pin's name and number; `sole` is the name if the sensor has one pin."""
    name, _, pin = text.rpartition("=")
    if not (name or sole):
        raise click.UsageError(f"--pin {text}: write NAME=PIN, such as TRIG=6")
    return (name or sole).upper(), pin.upper()
