"""Applies a plan to the parameter server before its nodes start: dump, delete, clear, set."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable
from pathlib import Path

from rostether.errors import ConfigError, UnknownNameError
from rostether.graph.ports import Level
from rostether.launch.plan import DeleteParameters, DumpParameters, LaunchPlan
from rostether.names.graph_name import SEPARATOR, canonical
from rostether.param_yaml import dump
from rostether.ros1.node.master_client import MasterClient

# The caller id of a launch, which also replaces `~` in a parameter's name.
CALLER_ID = "/roslaunch"

_RUN_ID = "/run_id"


async def ensure_run_id(client: MasterClient) -> str:
    """Return the id of the master's run; create one if there is none."""
    try:
        return str(await client.get_param(_RUN_ID))
    except UnknownNameError:
        run_id = str(uuid.uuid1())
        await client.set_param(_RUN_ID, run_id)
        return run_id


async def upload(plan: LaunchPlan, client: MasterClient, report: Callable[[Level, str], None]) -> None:
    """Apply the plan. Raises GraphError, and ConfigError for a file that cannot be written."""
    for step in plan.before:
        match step:
            case DumpParameters():
                await _dump(step, client)
            case DeleteParameters():
                if not await _delete(step.name, client):
                    report(Level.WARN, f"parameter {canonical(step.name)} is not set; nothing was deleted")
    for namespace in outermost(plan.cleared):
        await _delete(namespace, client)
    for name, value in plan.parameters.items():
        await client.set_param(name, value)


def outermost(namespaces: Iterable[str]) -> list[str]:
    """Return the namespaces that are not inside another one; all end with a slash."""
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
        value = await client.get_param(canonical(step.namespace))
    except UnknownNameError:
        value = {}
    try:
        Path(step.file).write_text(dump(value), "utf-8")  # noqa: ASYNC240 - no other task runs yet
    except OSError as error:
        raise ConfigError(f"cannot write {step.file}: {error.strerror}") from None
