"""A gateway as a separate command: on the chosen graphs, until its node ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Protocol

from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.ros1_access import read_environment
from rostether.cli.access.served_graphs import ServedGraphs, served_graphs
from rostether.cli.gateway.gateways import Tell
from rostether.cli.shell.running import run
from rostether.graph.ports import Level


class Gateway(Protocol):
    """What serves clients."""

    async def wait_ended(self) -> None:
        """Wait until its node has left the graph."""


def serve_gateway(
    graph: GraphOptions,
    msg_paths: Sequence[Path],
    open_gateway: Callable[[ServedGraphs, Tell], AbstractAsyncContextManager[Gateway]],
) -> None:
    """Run a gateway on the graphs that this command line means. Raises what `served_graphs` does."""
    environment = read_environment(graph)

    async def serve() -> None:
        tell = ConsoleReporter().line
        async with served_graphs(environment, graph, msg_paths=msg_paths) as graphs:
            for line in graphs.lines:
                tell(Level.INFO, line)
            async with open_gateway(graphs, tell) as gateway:
                await gateway.wait_ended()

    run(serve(), is_service=True)
