"""Which master a bridge uses: the one it was told, else the one that answers here, else one of its own.

--master, or a ROS_MASTER_URI that is not loopback   that one; it is waited for as long as it takes
otherwise                                            the one that answers on loopback, else be it
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace

from rostether.errors import GraphError, MasterUnreachableError
from rostether.ros1.environment import RosEnvironment, format_uri
from rostether.ros1.node.master_client import MasterClient

# A master on loopback answers within milliseconds; one that is only starting gets this long before its port
# counts as somebody else's.
_ANSWER_LIMIT_S = 2.0


@dataclass(frozen=True, slots=True)
class UsedMaster:
    """The environment to join with, a line for people about the master in it, and whether that is us."""

    environment: RosEnvironment
    line: str
    is_ours: bool = False


@asynccontextmanager
async def used_master(
    environment: RosEnvironment, *, is_chosen: bool = False, port: int | None = None
) -> AsyncIterator[UsedMaster]:
    """Find the master to use, being it for as long as the block lasts where there is none.

    `is_chosen` says that the user named it (`--master`); `port` is where we are it (`--master-port`).
    Raises GraphError when the port is taken by something that is no master.
    """
    if is_chosen or (environment.master_uri_is_set and not environment.master.is_loopback):
        yield UsedMaster(environment, f"Using the ROS master at {environment.master_uri}")
        return
    if port is not None:
        environment = replace(environment, master_uri=format_uri("localhost", port))
    if await master_answers(environment):
        yield UsedMaster(environment, f"Joining the ROS master at {environment.master_uri}")
        return
    from rostether.ros1.roscore import Roscore

    try:
        core = await Roscore.start(environment, port=environment.master.port)
    except GraphError:
        # Somebody else took the port since we asked: joined if it is a master.
        if not await master_answers(environment):
            raise
        yield UsedMaster(environment, f"Joining the ROS master at {environment.master_uri}")
        return
    try:
        line = f"Being the ROS master: ROS_MASTER_URI={core.uri.rstrip('/')}"
        yield UsedMaster(environment, line, is_ours=True)
    finally:
        await core.close()


async def master_answers(environment: RosEnvironment) -> bool:
    """Tell whether a ROS master answers where the environment says."""
    client = MasterClient(environment.master_uri, "/rostether")
    try:
        async with asyncio.timeout(_ANSWER_LIMIT_S):
            await client.get_pid()
    except (MasterUnreachableError, TimeoutError):
        return False
    finally:
        await client.close()
    return True
