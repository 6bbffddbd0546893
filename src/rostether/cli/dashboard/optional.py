"""Serves the dashboard if a command requests it.

The modules of the dashboard are imported only then, because most bridges start without one.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from rostether.cli.access.served_graphs import ServedGraphs
    from rostether.cli.dashboard.served import Dashboard
    from rostether.cli.dashboard.settings import DashboardSettings
    from rostether.cli.gateway.gateways import Report


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
