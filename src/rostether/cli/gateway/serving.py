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
from rostether.cli.gateway.gateways import Report
from rostether.cli.shell.running import run
from rostether.graph.ports import Level


class Gateway(Protocol):
    """A running gateway."""

    async def wait_ended(self) -> None:
        """Wait until its node has left the graph."""


def serve_gateway(
    graph: GraphOptions,
    msg_paths: Sequence[Path],
    open_gateway: Callable[[ServedGraphs, Report], AbstractAsyncContextManager[Gateway]],
) -> None:
    """Run a gateway on the graphs that the command line selects. Raises as `served_graphs`."""
    environment = read_environment(graph)

    async def serve() -> None:
        report = ConsoleReporter().line
        async with served_graphs(environment, graph, msg_paths=msg_paths) as graphs:
            for line in graphs.lines:
                report(Level.INFO, line)
            async with open_gateway(graphs, report) as gateway:
                await gateway.wait_ended()

    run(serve(), is_service=True)
