"""`rostether graph`: nodes and the topics between them, as text or as a picture."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.ros1_access import master_client, read_environment
from rostether.cli.shell.option_group import FILE, add_flag, add_option
from rostether.cli.shell.output import json_option, write_file, write_json, write_line
from rostether.cli.shell.picture_files import SUFFIXES, encode, picture_format
from rostether.cli.shell.verbs import verb
from rostether.graph.shown_graph import ShownGraph, as_digraph, as_records, as_text, choose
from rostether.mechanisms.text import counted
from rostether.ros1.node.graph_view import take_snapshot


@verb(
    "graph",
    """
    rostether graph
    rostether graph --output graph.svg
    rostether graph --nodes-only --output graph.png
    rostether graph /arm /joint_states --format dot
    """,
    old_options={"--save": "--output"},
)
@click.argument("names", nargs=-1, metavar="[NAME...]")
@add_option(
    "--format format_name",
    "The output format on the terminal (default: text); --output writes a file.",
    type=click.Choice(["text", "dot", "svg"]),
)
@add_option(
    "-o --output file FILE", f"Write a file; its extension sets the format: {', '.join(SUFFIXES)}.", type=FILE
)
@add_flag("--nodes-only", "Show only nodes, with topics along the arrows.")
@add_flag("-a --all with_hidden", "Include logging, statistics and hidden names.")
@json_option
@graph_options()
async def show_graph(
    names: tuple[str, ...],
    format_name: str | None,
    file: Path | None,
    nodes_only: bool,
    with_hidden: bool,
    as_json: bool,
    graph: GraphOptions,
) -> None:
    """Show which nodes publish and subscribe to which topics, as rqt_graph does.

    If you give NAMEs of nodes, topics or namespaces, it shows only these and their neighbors. In text, -> is
    a published topic, <- a subscribed topic, => an offered service. Pictures show nodes as ellipses and
    topics as boxes; PNG needs `pip install 'rostether[pictures]'`.
    """
    if sum([format_name is not None, file is not None, as_json]) > 1:
        raise click.UsageError("give one of --format, --output and --json")
    kind = picture_format(file) if file is not None else format_name or "text"
    if graph.ros2 is not None:
        from rostether.cli.access.ros2_tool_node import asked
        from rostether.ros2.graph_view import as_snapshot

        snapshot = as_snapshot(await asked(graph, lambda tool: tool.settled_snapshot()))
    else:
        async with master_client(read_environment(graph)) as client:
            snapshot = await take_snapshot(client)
    shown = choose(snapshot, names, with_hidden=with_hidden)
    if as_json:
        for record in as_records(shown):
            write_json(record)
    elif file is not None:
        write_file(file, _content(shown, kind, nodes_only=nodes_only))
        write_line(f"{file}: {counted(len(shown.nodes), 'node')}, {counted(len(shown.topics), 'topic')}")
    else:
        write_line(str(_content(shown, kind, nodes_only=nodes_only)).rstrip("\n"))


def _content(shown: ShownGraph, kind: str, *, nodes_only: bool) -> str | bytes:
    if kind == "text":
        return "\n".join(as_text(shown))
    from rostether.pictures.digraph import dot, draw

    digraph = as_digraph(shown, nodes_only=nodes_only)
    if kind == "dot":
        return dot(digraph)
    return encode(draw(digraph), kind)
