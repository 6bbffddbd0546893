"""`rostether link record`: serves a board and records its line."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.access.completions import complete_ports
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import ADDRESS_HINTS, listen_option, msg_path_option
from rostether.cli.bag.bridge_recording import record_limit_option
from rostether.cli.bridge.serve import serve
from rostether.cli.shell.option_group import FILE
from rostether.cli.shell.verbs import verb


@verb(
    "record",
    """
    rostether link record /dev/ttyACM0 problem.jsonl
    rostether link record "/dev/ttyUSB0?baud=115200" problem.jsonl
    rostether link record tcp://:11411 problem.jsonl --record-limit 10
    """,
    hints=ADDRESS_HINTS,
)
@click.argument("address", shell_complete=complete_ports)
@click.argument("file", type=FILE)
@record_limit_option
@listen_option
@graph_options(served=True, ros=False)
@msg_path_option
@click.pass_context
def link_record(
    ctx: click.Context,
    address: str,
    file: Path,
    record_limit_mb: float,
    listen: str | None,
    msg_paths: tuple[Path, ...],
    graph: GraphOptions,
) -> None:
    """Serve the board at ADDRESS, as `rostether serve` does, and record its line to FILE until Ctrl-C.

    The bridge itself records, so it opens the port only once. FILE must not exist. If the command is
    killed, only the last 0.2 s are missing. FILE contains every message between board and host.
    """
    ctx.invoke(
        serve,
        addresses=(address,),
        master=graph.master,
        record_line=file,
        record_limit_mb=record_limit_mb,
        listen=listen,
        allow=graph.allow,
        msg_paths=msg_paths,
    )
