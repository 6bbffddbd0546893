"""Opens a session on the selected ROS 2 graph, through zenoh or rclpy."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct

from rostether.cli.access.graph_options import Middleware
from rostether.graph.ports import Graph, JoinGraph
from rostether.mechanisms.block_end import closed_at_end
from rostether.names.graph_name import join as join_names
from rostether.ros2.environment import Ros2Environment, ZenohReach

if TYPE_CHECKING:
    from rostether.ros2.types.type_support import Ros2Types


class Ros2Access(Struct, frozen=True):
    """A session on a ROS 2 graph: its node factory, its types, and a line for users.

    Over zenoh, `listens_on` and `connects_to` are endpoints of the session. `is_router` is true for this
    machine's router; `is_linked` returns whether a router or another peer is connected.
    """

    join: JoinGraph
    types: Ros2Types
    line: str
    listens_on: tuple[str, ...] = ()
    connects_to: tuple[str, ...] = ()
    is_router: bool = False
    is_linked: Callable[[], bool] = lambda: True


@asynccontextmanager
async def ros2_access(
    middleware: Middleware,
    msg_paths: Iterable[Path] = (),
    *,
    reach: ZenohReach | None = None,
    params_files: Iterable[Path] = (),
    types: Ros2Types | None = None,
) -> AsyncIterator[Ros2Access]:
    """Join the ROS 2 graph until the end of the block.

    `types` replace those from `msg_paths` and the environment. Raises ConfigError for a missing package or
    folder, and GraphError if the middleware cannot open a session.
    """
    from rostether.msgdef.registry import Registry
    from rostether.msgdef.ros2.definitions import Ros2Definitions
    from rostether.ros2.types.type_support import Ros2Types

    paths = tuple(msg_paths)
    if types is None:
        types = Ros2Types(Registry.from_environment(paths), Ros2Definitions.from_environment(paths))
    environment = Ros2Environment.read()
    if middleware is Middleware.RCLPY:
        opening = _over_rclpy(environment, types, tuple(params_files))
    else:
        opening = _over_zenoh(environment, types, reach or ZenohReach(), tuple(params_files))
    async with opening as access:
        yield access


@asynccontextmanager
async def _over_rclpy(
    environment: Ros2Environment, types: Ros2Types, params_files: tuple[Path, ...]
) -> AsyncIterator[Ros2Access]:
    from rostether.ros2.rclpy.graph import RclpyContext

    arguments = ["--ros-args"] if params_files else []
    for path in params_files:
        arguments += ["--params-file", str(path)]
    context = await RclpyContext.open(types, domain_id=environment.domain_id, arguments=arguments)
    async with closed_at_end(context):
        using = environment.middleware or "rclpy's own middleware"
        yield Ros2Access(context.join, types, f"Joining ROS 2 domain {environment.domain_id} over {using}")


@asynccontextmanager
async def _over_zenoh(
    environment: Ros2Environment, types: Ros2Types, reach: ZenohReach, params_files: tuple[Path, ...]
) -> AsyncIterator[Ros2Access]:
    from rostether.ros2.parameters.parameter_file import read_parameter_files
    from rostether.ros2.session import zenoh_sessions

    sessions = zenoh_sessions()
    rules = read_parameter_files(params_files)
    session = await sessions.open(environment, types, reach=reach)

    async def join(
        node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        initial = rules.for_node(join_names(namespace, node_name))
        return await session.join(node_name, namespace=namespace, remappings=remappings, parameters=initial)

    async with closed_at_end(session):
        line = f"Joining ROS 2 domain {environment.domain_id} over zenoh (RMW_IMPLEMENTATION=rmw_zenoh_cpp)"
        if session.is_router:
            line += "; this command is the router of this machine"
        yield Ros2Access(
            join, types, line, session.listens_on, session.connects_to, session.is_router, session.is_linked
        )
