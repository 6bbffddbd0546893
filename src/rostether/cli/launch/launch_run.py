"""Runs launch files: a master, the nodes, and a dashboard."""

from __future__ import annotations

import os

import click
from msgspec import Struct
from msgspec.structs import replace

from rostether.cli.access.ros1_access import no_master, ros1_join
from rostether.cli.access.served_graphs import ServedGraphs, master_answers, used_master, wait_for_answer
from rostether.cli.dashboard.browser import has_browser, open_browser
from rostether.cli.dashboard.optional import optional_dashboard
from rostether.cli.dashboard.settings import DashboardSettings
from rostether.cli.launch.loaded_launch import LoadedLaunch
from rostether.cli.shell.failures import print_error
from rostether.cli.shell.output import warn, write_line
from rostether.errors import MasterUnreachableError
from rostether.graph.ports import Level
from rostether.launch.runner import RunOptions, run_plan
from rostether.ros1.environment import RosEnvironment


class MasterSettings(Struct, frozen=True):
    """The master of the nodes; `is_chosen` if an option named it, `waits` if none may be started."""

    environment: RosEnvironment
    is_chosen: bool
    port: int | None
    waits: bool


async def run_launch(
    loaded: LoadedLaunch, master: MasterSettings, options: RunOptions, dashboard: DashboardSettings | None
) -> None:
    """Run the nodes until all have ended. Raises click's Exit if a required one failed."""
    if master.waits and not await master_answers(master.environment):
        write_line(f"Waiting for the ROS master at {master.environment.master_uri}")
        await wait_for_answer(master.environment)
    async with used_master(master.environment, is_chosen=master.is_chosen, port=master.port) as used:
        write_line(used.line)
        graphs = ServedGraphs(ros1_join(used.environment), used.environment, ())
        try:
            async with optional_dashboard(dashboard, graphs, loaded.package_folders, _report) as served:
                if served is not None and has_browser(os.environ):
                    for url in served.view_urls:
                        await open_browser(url)
                succeeded = await run_plan(
                    loaded.plan,
                    master_uri=used.environment.master_uri,
                    environ=loaded.environ,
                    locate=loaded.locate,
                    report=_report,
                    options=replace(options, stays=used.is_started_here or dashboard is not None),
                )
        except MasterUnreachableError as error:
            raise no_master(used.environment, error) from error
    if not succeeded:
        raise click.exceptions.Exit(1)


def _report(level: int, text: str) -> None:
    if level >= Level.ERROR:
        print_error(text)
    elif level >= Level.WARN:
        warn(f"WARNING: {text}")
    else:
        write_line(text)
