"""Serves the gateways and the dashboard that a command requests.

Their modules are imported only then, because most bridges start without them.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.dashboard.settings import DashboardSettings
from rostether.cli.gateway.gateways import NodeNaming, Report, open_gateway_graph
from rostether.cli.gateway.options import GatewayOptions

if TYPE_CHECKING:
    from rostether.cli.dashboard.served import Dashboard


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


@asynccontextmanager
async def optional_dashboard(
    settings: DashboardSettings | None, graphs: ServedGraphs, msg_paths: Sequence[Path], report: Report
) -> AsyncIterator[Dashboard | None]:
    """Serve the dashboard unless `settings` is None. Raises the same errors as `served_dashboard`."""
    if settings is None:
        yield None
        return
    from rostether.cli.dashboard.served import served_dashboard

    async with served_dashboard(settings, graphs, msg_paths, report) as dashboard:
        yield dashboard
