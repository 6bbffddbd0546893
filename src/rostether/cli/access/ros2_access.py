"""Opens a session on the selected ROS 2 graph, with the types of the command line."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import Middleware
from rostether.ros2.session import Ros2Access, open_ros2
from rostether.ros2.zenoh_reach import ZenohReach

if TYPE_CHECKING:
    from rostether.ros2.types.type_support import Ros2Types


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
    async with open_ros2(middleware, types, reach=reach, params_files=params_files) as access:
        yield access
