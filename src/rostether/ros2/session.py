"""Joins a program to a ROS 2 graph over the chosen middleware."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rostether.errors import ConfigError
from rostether.extras import install_command
from rostether.graph.ports import JoinGraph
from rostether.mechanisms.block_end import closed_at_end
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.types.type_support import Ros2Types

if TYPE_CHECKING:
    from rostether.ros2.zenoh.session import ZenohSession


@asynccontextmanager
async def open_ros2(
    middleware: str, types: Ros2Types, environ: Mapping[str, str] | None
) -> AsyncIterator[JoinGraph]:
    """Yield a function that joins nodes during the block; `middleware` is zenoh or rclpy.

    `environ` None means os.environ. Raises ConfigError if the middleware is unknown or not installed,
    GraphError if the graph cannot be joined.
    """
    environment = Ros2Environment.read(environ)
    if middleware == "rclpy":
        from rostether.ros2.rclpy.graph import RclpyContext

        async with closed_at_end(await RclpyContext.open(types, domain_id=environment.domain_id)) as context:
            yield context.join
        return
    if middleware != "zenoh":
        raise ConfigError(f"unknown middleware {middleware!r}; give zenoh or rclpy")
    async with closed_at_end(await zenoh_sessions().open(environment, types)) as session:
        yield session.join


def zenoh_sessions() -> type[ZenohSession]:
    """Import and return the class of zenoh sessions. Raises ConfigError with the command to install zenoh."""
    try:
        from rostether.ros2.zenoh.session import ZenohSession
    except ModuleNotFoundError as error:
        if error.name not in ("zenoh", "xxhash"):
            raise
        raise ConfigError(f"zenoh support is not installed; run: {install_command('zenoh')}") from None
    return ZenohSession
