"""Runs a plan: sets parameters, starts the nodes, and waits until a required node or all nodes have ended."""

from __future__ import annotations

import asyncio
import uuid
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from msgspec import Struct, field
from msgspec.structs import replace

from rostether.errors import ConfigError, LaunchError, RostetherError, UnknownNameError
from rostether.graph.ports import Level
from rostether.launch.command_line import Locate, Replaced, command_of, log_folder
from rostether.launch.node_process import NodeProcess, StopLimits, adopt_orphans
from rostether.launch.plan import DeleteParameters, DumpParameters, LaunchNode, LaunchPlan, Output
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.tasks import cancel_all
from rostether.mechanisms.text import write_failure
from rostether.names.graph_name import SEPARATOR, canonical
from rostether.param_yaml import dump
from rostether.ros1.node.master_client import MasterClient

# The caller id of a launch, which also replaces `~` in a parameter's name.
CALLER_ID = "/roslaunch"

_RUN_ID = "/run_id"


class RunOptions(Struct, frozen=True):
    """The settings of the command line for all nodes.

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
    """Run a plan to its end, and end all its processes, even when canceled.

    `locate` finds the programs of nodes, `report` gets each line with its level. Returns False if a required
    node failed, or if no node could be started. Raises GraphError, such as MasterUnreachableError, and
    ConfigError before it starts any node.
    """
    async with closed_at_end(MasterClient(master_uri, CALLER_ID)) as client:
        logs = log_folder(environ, await _ensure_run_id(client))
        report(Level.INFO, f"logs: {logs}")
        await _apply_parameters(plan, client, report)
    adopt_orphans()
    # Unbuffered: the last output of a killed script must be in its log.
    launch = _Launch(master_uri, {"PYTHONUNBUFFERED": "1", **environ}, locate, report, options, logs)
    try:
        return await launch.run([_with_options(node, options) for node in plan.nodes])
    finally:
        await launch.stop()


class _Launch(Struct):
    master_uri: str
    environ: Mapping[str, str]
    locate: Locate
    report: Callable[[Level, str], None]
    options: RunOptions
    logs: Path
    processes: list[NodeProcess] = field(default_factory=list)
    supervisors: dict[asyncio.Task[None], NodeProcess] = field(default_factory=dict)

    async def run(self, nodes: list[LaunchNode]) -> bool:
        has_failed = False
        for number, node in enumerate(nodes, 1):
            if not await self._start(node, number):
                has_failed = True
                if node.required:
                    return False
        if has_failed and not self.supervisors:
            return False
        if not nodes:
            self.report(Level.INFO, "the parameters are set; there is no node to start")
        waiting = set(self.supervisors)
        while waiting:
            ended, waiting = await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
            for task in ended:
                process = self.supervisors[task]
                if task.exception() is not None:
                    self.report(Level.ERROR, str(task.exception()))
                if process.node.required:
                    succeeded = task.exception() is None and process.exit_code == 0
                    line = f"[{process.name}] is required and has ended; stopping all nodes"
                    self.report(Level.WARN if succeeded else Level.ERROR, line)
                    return succeeded
        if self.options.stays:
            self.report(Level.INFO, "all nodes have ended; the launch continues until Ctrl-C")
            await asyncio.Event().wait()
        return True

    async def _start(self, node: LaunchNode, number: int) -> bool:
        name = f"{node.full_name.removeprefix('/')}-{number}"
        try:
            # Runs in a thread, because finding a program searches its package.
            command = await asyncio.to_thread(command_of, node, self.environ, self.master_uri, self.locate)
            if isinstance(command, Replaced):
                self.report(Level.WARN, command.line)
                return True
            process = NodeProcess(node, command, name, self.logs, self.report, self.options.stop_limits)
            self.processes.append(process)
            await process.start()
        except LaunchError as error:
            self.report(Level.ERROR, str(error))
            return False
        except RostetherError as error:
            self.report(Level.ERROR, f"{node.file}:{node.line}: {error}")
            return False
        self.supervisors[asyncio.create_task(process.supervise())] = process
        return True

    async def stop(self) -> None:
        """End all running processes at the same time."""
        await cancel_all(*self.supervisors)
        await asyncio.gather(*(process.stop() for process in self.processes))


def _with_options(node: LaunchNode, options: RunOptions) -> LaunchNode:
    if options.output is not None:
        node = replace(node, output=options.output)
    # A node with respawn= never counts as ended.
    if options.all_required and not node.respawn:
        node = replace(node, required=True)
    return node


async def _ensure_run_id(client: MasterClient) -> str:
    """Return the id of the master's run; create one if there is none. Raises GraphError."""
    try:
        return str(await client.get_param(_RUN_ID))
    except UnknownNameError:
        run_id = str(uuid.uuid1())
        await client.set_param(_RUN_ID, run_id)
        return run_id


async def _apply_parameters(
    plan: LaunchPlan, client: MasterClient, report: Callable[[Level, str], None]
) -> None:
    """Apply the plan to the master's parameters. Raises GraphError, ConfigError if a file is not writable."""
    for step in plan.before:
        match step:
            case DumpParameters():
                await _dump(step, client)
            case DeleteParameters():
                if not await _delete(step.name, client):
                    report(Level.WARN, f"parameter {step.name} is not set; nothing was deleted")
    for namespace in outermost(plan.cleared):
        await _delete(namespace, client)
    for name, value in plan.parameters.items():
        await client.set_param(name, value)


def outermost(namespaces: Iterable[str]) -> list[str]:
    """Return the namespaces that are not inside another one, each once; all end with a slash."""
    unique = list(dict.fromkeys(namespaces))
    return [each for each in unique if not any(each != other and each.startswith(other) for other in unique)]


async def _delete(name: str, client: MasterClient) -> bool:
    if canonical(name) == SEPARATOR:
        # The root always has a value: deleting it means emptying it.
        await client.set_param(SEPARATOR, {})
        return True
    try:
        await client.delete_param(canonical(name))
    except UnknownNameError:
        return False
    return True


async def _dump(step: DumpParameters, client: MasterClient) -> None:
    try:
        value = await client.get_param(step.namespace)
    except UnknownNameError:
        value = {}
    try:
        Path(step.file).write_text(dump(value), "utf-8")  # noqa: ASYNC240 - no other task runs yet
    except OSError as error:
        raise ConfigError(write_failure(step.file, error)) from None
