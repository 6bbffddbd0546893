"""The gateways that run beside a bridge: `serve --rosbridge --foxglove`."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.gateway.options import GatewayOptions

if TYPE_CHECKING:
    from rostether.cli.gateway.gateways import Report


@asynccontextmanager
async def served_gateways(
    options: GatewayOptions,
    graphs: ServedGraphs,
    graph_options: GraphOptions,
    msg_paths: Sequence[Path],
    report: Report,
) -> AsyncIterator[None]:
    """Run the requested gateways, if any. Raises as `rosbridge_gateway`."""
    async with AsyncExitStack() as stack:
        if options.rosbridge is not None:
            from rostether.cli.gateway.gateways import gateway_graph, rosbridge_gateway

            graph = await stack.enter_async_context(gateway_graph(graphs, graph_options, msg_paths))
            await stack.enter_async_context(rosbridge_gateway(options, graph, report))
        if options.foxglove is not None:
            from rostether.cli.gateway.foxglove import served_foxglove

            await stack.enter_async_context(served_foxglove(options, graphs, msg_paths, report))
        yield
