"""Joins a program to a ROS 2 graph over the chosen middleware."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.extras import install_command
from rostether.graph.ports import Graph, JoinGraph
from rostether.mechanisms.block_end import closed_at_end
from rostether.names.graph_name import join as join_names
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.zenoh_reach import ZenohReach

if TYPE_CHECKING:
    from rostether.ros2.types.type_support import Ros2Types
    from rostether.ros2.zenoh.session import ZenohSession


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
async def open_ros2(
    middleware: str,
    types: Ros2Types,
    environ: Mapping[str, str] | None = None,
    *,
    reach: ZenohReach | None = None,
    params_files: Iterable[Path] = (),
) -> AsyncIterator[Ros2Access]:
    """Open a session until the end of the block; `middleware` is zenoh or rclpy, and `reach` is for zenoh.

    `environ` None means os.environ. Raises ConfigError if the middleware is unknown or not installed, or a
    parameter file is invalid, and GraphError if the graph cannot be joined.
    """
    environment = Ros2Environment.read(environ)
    line = f"Joining ROS 2 domain {environment.domain_id} over"
    if middleware == "rclpy":
        from rostether.ros2.rclpy.context import RclpyContext

        arguments = [word for path in params_files for word in ("--params-file", str(path))]
        context = await RclpyContext.open(
            types, domain_id=environment.domain_id, arguments=["--ros-args", *arguments] if arguments else ()
        )
        async with closed_at_end(context):
            using = environment.middleware or "rclpy's own middleware"
            yield Ros2Access(context.join, types, f"{line} {using}")
        return
    if middleware != "zenoh":
        raise ConfigError(f"unknown middleware {middleware!r}; give zenoh or rclpy")
    from rostether.ros2.parameters.parameter_file import read_parameter_files

    sessions = zenoh_sessions()
    rules = read_parameter_files(params_files)
    session = await sessions.open(environment, types, reach=reach)

    async def join(
        node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        initial = rules.for_node(join_names(namespace, node_name))
        return await session.join(node_name, namespace=namespace, remappings=remappings, parameters=initial)

    async with closed_at_end(session):
        line = f"{line} zenoh (RMW_IMPLEMENTATION=rmw_zenoh_cpp)"
        if session.is_router:
            line += "; this command is the router of this machine"
        yield Ros2Access(
            join, types, line, session.listens_on, session.connects_to, session.is_router, session.is_linked
        )


def zenoh_sessions() -> type[ZenohSession]:
    """Import and return the class of zenoh sessions. Raises ConfigError with the command to install zenoh."""
    try:
        from rostether.ros2.zenoh.session import ZenohSession
    except ModuleNotFoundError as error:
        if error.name not in ("zenoh", "xxhash"):
            raise
        raise ConfigError(f"zenoh support is not installed; run: {install_command('zenoh')}") from None
    return ZenohSession
