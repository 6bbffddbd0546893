"""`rostether tf tree`: the frames of tf, each below its parent."""

from __future__ import annotations

import asyncio

from msgspec.structs import asdict

from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import POSITIVE, add_flag, add_option
from rostether.cli.shell.output import json_option, paint_frame, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.mechanisms.text import escape_line

# Long enough for transforms at 1 Hz, and to measure a rate.
DEFAULT_LISTENING_S = 2.0
# More lines would push the tree off the screen.
_MAX_REFUSALS = 20


@verb(
    "tree",
    """
    rostether tf tree
    rostether tf tree --duration 10
    rostether tf tree --ros2
    rostether tf tree --dot | dot -Tpdf > frames.pdf
    """,
    old_options={"--time": "--duration"},
)
@add_option(
    "--duration listening_s SECONDS",
    f"How long to listen (default: {DEFAULT_LISTENING_S:g}).",
    type=POSITIVE,
    default=DEFAULT_LISTENING_S,
)
@add_flag("--dot", "Print the tree for graphviz.")
@json_option
@graph_options(allow=True)
def tree(listening_s: float, dot: bool, as_json: bool, graph: GraphOptions) -> int:
    """Listen for a while, then show the tree of frames with the nodes that broadcast them."""
    return run(_tree(listening_s, dot, as_json, graph))


async def _tree(listening_s: float, dot: bool, as_json: bool, graph: GraphOptions) -> int:
    from rostether.cli.access.either_graph import joined_either
    from rostether.robot.tf_listener import tf_listener
    from rostether.robot.tf_report import frame_facts, frame_tree, frames_as_dot

    refusals: dict[str, None] = {}

    def note(refusal: str) -> None:
        # Every message may cause the same refusal; the text before the frame is its kind.
        kind = refusal.split(" for frame ")[0]
        if len(refusals) < _MAX_REFUSALS:
            refusals.setdefault(kind)

    async with (
        joined_either(graph, purpose="view_frames") as (node, _),
        tf_listener(node, on_refusal=note) as listener,
    ):
        await asyncio.sleep(listening_s)
        buffer = listener.buffer
    for refusal in refusals:
        warn(escape_line(refusal))
    if not buffer.frames:
        warn(
            f"no transform was received within {listening_s:g} s; "
            "start robot_state_publisher or `rostether tf static`, which publish transforms"
        )
        return EXIT_FAILED
    if as_json:
        for facts in frame_facts(buffer):
            write_json(asdict(facts))
    elif dot:
        write_line(frames_as_dot(buffer))
    else:
        for line in frame_tree(buffer):
            write_line(escape_line(line), paint_frame)
    return EXIT_DONE
