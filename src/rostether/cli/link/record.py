"""`rostether link record`: a board served as usual, and its line recorded."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.access.options import allow_option, listen_option, msg_path_option
from rostether.cli.bag.recording import record_limit_option
from rostether.cli.bridge.serve import serve
from rostether.cli.shell.verbs import Verb


@click.command(
    "record",
    cls=Verb,
    examples="""
    rostether link record /dev/ttyACM0 problem.jsonl
    rostether link record "/dev/ttyUSB0?baud=115200" problem.jsonl
    rostether link record tcp://:11411 problem.jsonl --record-limit 10
    """,
)
@click.argument("address")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--master", metavar="URI", help="The ROS master to join; it is waited for.")
@record_limit_option
@listen_option
@allow_option
@msg_path_option
@click.pass_context
def link_record(
    ctx: click.Context,
    address: str,
    file: Path,
    master: str | None,
    record_limit_mb: float,
    listen: str | None,
    allowed: tuple[str, ...],
    msg_paths: tuple[Path, ...],
) -> None:
    """Serve the board at ADDRESS, as `rostether serve` does, and record its line to FILE until Ctrl-C.

    The port is read once: recording sits in the bridge. FILE must not exist. What came until then is in it
    even when the command is killed. It holds all that the board and the host said: every message.
    """
    ctx.invoke(
        serve,
        addresses=(address,),
        master=master,
        record_line=file,
        record_limit_mb=record_limit_mb,
        listen=listen,
        allowed=allowed,
        msg_paths=msg_paths,
    )
