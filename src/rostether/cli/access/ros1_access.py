"""Connects commands to a ROS 1 graph: through the master for listings, as a node for messages and calls."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import GraphOptions
from rostether.errors import MasterUnreachableError
from rostether.mechanisms.block_end import closed_at_end
from rostether.names.graph_name import resolve_name
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.node_queries import TOOL_NAME
from rostether.transports.sockets import explain_reason

if TYPE_CHECKING:
    from rostether.graph.ports import JoinGraph
    from rostether.graph.typed_graph import TypedGraph
    from rostether.serde.store import TypeStore

_ENVIRONMENT_OF_ARGUMENT = {
    "__ns": "ROS_NAMESPACE",
    "__master": "ROS_MASTER_URI",
    "__ip": "ROS_IP",
    "__hostname": "ROS_HOSTNAME",
}


def read_environment(graph: GraphOptions, listen: str | None = None) -> RosEnvironment:
    """Return the ROS environment of a command; options override variables. Raises ConfigError.

    `listen` is the value of `--listen`.
    """
    variables = dict(os.environ)
    variables.update(
        {
            _ENVIRONMENT_OF_ARGUMENT[key]: graph.arguments[key]
            for key in graph.arguments.keys() & _ENVIRONMENT_OF_ARGUMENT
        }
    )
    environment = RosEnvironment.read(variables).allowing(graph.allow)
    if listen is not None:
        environment = environment.listening_on(listen)
    return environment if graph.master is None else environment.with_master(graph.master)


def type_store(msg_paths: Iterable[Path] = ()) -> TypeStore:
    """Return the message types; definitions in `msg_paths` take precedence. Raises ConfigError."""
    from rostether.msgdef.registry import Registry
    from rostether.serde.store import TypeStore

    return TypeStore(Registry.from_environment(msg_paths))


def resolve(name: str, environment: RosEnvironment) -> str:
    """Return the full form of a user's name. Raises InvalidNameError."""
    return resolve_name(name, namespace=environment.namespace, node_name=TOOL_NAME)


@asynccontextmanager
async def master_client(environment: RosEnvironment) -> AsyncIterator[MasterClient]:
    """Yield a client of the master, without a node. Raises MasterUnreachableError with advice."""
    async with closed_at_end(MasterClient(environment.master_uri, TOOL_NAME)) as client:
        try:
            yield client
        except MasterUnreachableError as error:
            raise no_master(environment, error) from error


@asynccontextmanager
async def joined(
    graph: GraphOptions,
    msg_paths: Iterable[Path] = (),
    *,
    purpose: str = "rostether",
    store: TypeStore | None = None,
    environment: RosEnvironment | None = None,
) -> AsyncIterator[TypedGraph]:
    """Run a node with a unique name, or with that of `__name:=`, until the end of the block.

    The node's name begins with `purpose`. `msg_paths` have no effect if there is a `store`; `environment` is
    that of `graph`, None to read it.

    Raises MasterUnreachableError with advice, ConfigError, InvalidNameError, GraphError.
    """
    from rostether.graph.typed_graph import TypedGraph
    from rostether.ros1.node.node import join_ros1

    environment = environment or read_environment(graph)
    try:
        node = await join_ros1(
            graph.node_name(purpose), environment=environment, namespace=environment.namespace
        )
        async with closed_at_end(node):
            yield TypedGraph(node, store or type_store(msg_paths))
    except MasterUnreachableError as error:
        raise no_master(environment, error) from error


def ros1_join(environment: RosEnvironment) -> JoinGraph:
    """Return the factory of ROS 1 nodes in an environment."""
    from rostether.ros1.node.node import join_ros1

    return partial(join_ros1, environment=environment)


def no_master(environment: RosEnvironment, error: MasterUnreachableError) -> MasterUnreachableError:
    """Return the error for a master that does not answer, with advice."""
    reason, cause = f"no ROS master answers at {environment.master_uri}", error.__cause__
    if isinstance(cause, OSError) and not isinstance(cause, ConnectionRefusedError):
        reason += f" ({explain_reason(cause)})"
    return MasterUnreachableError(
        f"{reason}; start one with `rostether core` or `rostether serve`, or set ROS_MASTER_URI"
    )
