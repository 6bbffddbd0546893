"""Serves the gateways that a command requests."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.gateway.gateways import NodeNaming, Report, open_gateway_graph
from rostether.cli.gateway.options import GatewayOptions


@asynccontextmanager
async def optional_gateways(
    options: GatewayOptions,
    graphs: ServedGraphs,
    graph_options: GraphOptions,
    msg_paths: Sequence[Path],
    report: Report,
) -> AsyncIterator[None]:
    """Serve the requested gateways, if any. Raises the same errors as `rosbridge_gateway`."""
    async with AsyncExitStack() as stack:
        if options.rosbridge is not None:
            from rostether.cli.gateway.rosbridge import rosbridge_gateway

            graph = await stack.enter_async_context(open_gateway_graph(graphs, graph_options, msg_paths))
            await stack.enter_async_context(rosbridge_gateway(options, graph, report))
        if options.foxglove is not None:
            from rostether.cli.gateway.foxglove import foxglove_gateway, read_settings

            settings = await asyncio.to_thread(read_settings, options.foxglove, options)
            remote_option = "--foxglove 0.0.0.0:{port}"
            await stack.enter_async_context(
                foxglove_gateway(settings, NodeNaming(), remote_option, msg_paths, graphs, report)
            )
        yield
