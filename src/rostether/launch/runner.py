"""Runs a plan: sets parameters, starts the nodes in order, and waits until all or a required one end."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from rostether.errors import LaunchError, RostetherError
from rostether.graph.ports import Level
from rostether.launch.command_line import Locate, Replaced, command_of
from rostether.launch.log_folder import log_folder
from rostether.launch.node_process import NodeProcess, StopLimits, adopt_orphans
from rostether.launch.parameter_upload import CALLER_ID, ensure_run_id, upload
from rostether.launch.plan import LaunchNode, LaunchPlan, Output
from rostether.ros1.node.master_client import MasterClient


@dataclass(frozen=True, slots=True)
class RunOptions:
    """The command line's settings for all nodes.

    `output` and `all_required` override the files. With `stays`, the launch continues after all nodes have
    ended, because it runs the master.
    """

    output: Output | None = None
    all_required: bool = False
    stays: bool = False
    stop_limits: StopLimits = field(default_factory=StopLimits)


async def run_plan(
    plan: LaunchPlan,
    *,
    master_uri: str,
    environ: Mapping[str, str],
    locate: Locate,
    report: Callable[[Level, str], None],
    options: RunOptions = RunOptions(),
) -> bool:
    """Run a plan to its end, and end all its processes, also when cancelled.

    Returns False if a required node failed, or if no node could be started. Raises MasterUnreachableError,
    GraphError, ConfigError before it starts any node.
    """
    client = MasterClient(master_uri, CALLER_ID)
    try:
        logs = log_folder(environ, await ensure_run_id(client))
        report(Level.INFO, f"logs: {logs}")
        await upload(plan, client, report)
    finally:
        await client.close()
    adopt_orphans()
    launch = _Launch(master_uri, environ, locate, report, options, logs)
    try:
        return await launch.run([_with_options(node, options) for node in plan.nodes])
    finally:
        await launch.stop()


class _Launch:
    def __init__(
        self,
        master_uri: str,
        environ: Mapping[str, str],
        locate: Locate,
        report: Callable[[Level, str], None],
        options: RunOptions,
        logs: Path,
    ) -> None:
        self._master_uri = master_uri
        # Unbuffered: the last output of a killed script must be in its log.
        self._environ = {"PYTHONUNBUFFERED": "1", **environ}
        self._locate = locate
        self._report = report
        self._options = options
        self._logs = logs
        self._processes: list[NodeProcess] = []
        self._keepers: dict[asyncio.Task[None], NodeProcess] = {}

    async def run(self, nodes: list[LaunchNode]) -> bool:
        failed = False
        for number, node in enumerate(nodes, 1):
            if not await self._start(node, number):
                failed = True
                if node.required:
                    return False
        if failed and not self._keepers:
            return False
        if not nodes:
            self._report(Level.INFO, "the parameters are set; there is no node to start")
        waiting = set(self._keepers)
        while waiting:
            ended, waiting = await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
            for task in ended:
                process = self._keepers[task]
                if task.exception() is not None:
                    self._report(Level.ERROR, str(task.exception()))
                if process.node.required:
                    succeeded = task.exception() is None and process.exit_code == 0
                    line = f"[{process.name}] is required and has ended; stopping all nodes"
                    self._report(Level.WARN if succeeded else Level.ERROR, line)
                    return succeeded
        if self._options.stays:
            self._report(Level.INFO, "all nodes have ended; the launch continues until Ctrl-C")
            await asyncio.Event().wait()
        return True

    async def _start(self, node: LaunchNode, number: int) -> bool:
        name = f"{node.full_name.removeprefix('/')}-{number}"
        try:
            # In a thread, because finding a program searches its package.
            command = await asyncio.to_thread(command_of, node, self._environ, self._master_uri, self._locate)
            if isinstance(command, Replaced):
                self._report(Level.WARN, command.line)
                return True
            process = NodeProcess(node, command, name, self._logs, self._report, self._options.stop_limits)
            self._processes.append(process)
            await process.start()
        except LaunchError as error:
            self._report(Level.ERROR, str(error))
            return False
        except RostetherError as error:
            self._report(Level.ERROR, f"{node.file}:{node.line}: {error}")
            return False
        self._keepers[asyncio.create_task(process.keep())] = process
        return True

    async def stop(self) -> None:
        """End all running processes at the same time."""
        for task in self._keepers:
            task.cancel()
        if self._keepers:
            await asyncio.wait(self._keepers)
        await asyncio.gather(*(process.stop() for process in self._processes))


def _with_options(node: LaunchNode, options: RunOptions) -> LaunchNode:
    if options.output is not None:
        node = replace(node, output=options.output)
    # A node with respawn= never counts as ended.
    if options.all_required and not node.respawn:
        node = replace(node, required=True)
    return node
