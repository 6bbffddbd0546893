"""How commands reach the graph: the master alone for listings, a node of our own for messages and calls."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.options import ALLOWED
from rostether.errors import MasterUnreachableError
from rostether.names.resolve import resolve_name
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.serde.store import TypeStore

OUR_NAME = "/rostether"
"""The caller id of commands that are no node, and what `~` in a name given to one means."""

_ENVIRONMENT_OF_SPECIAL = {
    "__ns": "ROS_NAMESPACE",
    "__master": "ROS_MASTER_URI",
    "__ip": "ROS_IP",
    "__hostname": "ROS_HOSTNAME",
}


def special_arguments() -> Mapping[str, str]:
    """Return the ROS arguments such as `__name:=x` of this command line."""
    context = click.get_current_context(silent=True)
    specials = context.find_root().obj if context is not None else None
    return specials if isinstance(specials, dict) else {}


def read_environment(master: str | None = None) -> RosEnvironment:
    """Return the ROS environment under this command line; `--master` wins. Raises ConfigError."""
    specials = special_arguments()
    variables = dict(os.environ)
    variables.update(
        {_ENVIRONMENT_OF_SPECIAL[key]: specials[key] for key in specials.keys() & _ENVIRONMENT_OF_SPECIAL}
    )
    environment = RosEnvironment.read(variables)
    context = click.get_current_context(silent=True)
    environment = environment.allowing(context.meta.get(ALLOWED, ()) if context is not None else ())
    return environment if master is None else environment.with_master(master)


def resolve(name: str, environment: RosEnvironment) -> str:
    """Return the full form of a name that a user typed. Raises InvalidNameError."""
    return resolve_name(name, namespace=environment.namespace, node_name=OUR_NAME)


def in_namespace(name: str, namespace: str) -> bool:
    """Tell whether a full name is a namespace or lies in it."""
    return name == namespace or name.startswith(namespace.rstrip("/") + "/")


@asynccontextmanager
async def master_client(
    environment: RosEnvironment, caller_id: str = OUR_NAME
) -> AsyncIterator[MasterClient]:
    """Talk to the master without being a node. Raises MasterUnreachableError with what to do next."""
    client = MasterClient(environment.master_uri, caller_id)
    try:
        yield client
    except MasterUnreachableError as error:
        raise no_master(environment, error) from error
    finally:
        await client.close()


@asynccontextmanager
async def joined(
    environment: RosEnvironment,
    msg_paths: Iterable[Path] = (),
    *,
    purpose: str = "rostether",
    store: TypeStore | None = None,
) -> AsyncIterator[TypedGraph]:
    """Be a node with a name that nobody else has. Raises MasterUnreachableError with what to do next."""
    from rostether.graph.typed_graph import TypedGraph
    from rostether.joining import anonymous_name
    from rostether.ros1.node.node import join_ros1

    if store is None:
        from rostether.msgdef.registry import Registry
        from rostether.serde.store import TypeStore

        store = TypeStore(Registry.from_environment(msg_paths))
    name = special_arguments().get("__name") or anonymous_name(purpose)
    try:
        graph = await join_ros1(name, environment=environment, namespace=environment.namespace)
        try:
            yield TypedGraph(graph, store)
        finally:
            await graph.close()
    except MasterUnreachableError as error:
        raise no_master(environment, error) from error


def no_master(environment: RosEnvironment, error: MasterUnreachableError) -> MasterUnreachableError:
    """Return the error that tells a user what to do about a master that does not answer."""
    cause = error.__cause__
    if isinstance(cause, ConnectionRefusedError) or not isinstance(cause, OSError):
        reason = f"no ROS master answers at {environment.master_uri}"
    else:
        reason = f"no ROS master answers at {environment.master_uri} ({cause.strerror or cause})"
    return MasterUnreachableError(
        f"{reason}; start one with `rostether core` or `rostether serve`, or set ROS_MASTER_URI"
    )
