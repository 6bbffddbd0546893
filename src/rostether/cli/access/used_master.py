"""Chooses the master of a bridge: the given one, else one that answers on this machine, else a new one.

--master, or a ROS_MASTER_URI that is not loopback   that one; the bridge waits for it otherwise the one that
answers on loopback, else start one
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace

from rostether.errors import GraphError, MasterUnreachableError
from rostether.ros1.environment import RosEnvironment, format_uri
from rostether.ros1.node.master_client import MasterClient

# A master on loopback answers within milliseconds; a starting one gets this long before its port counts as
# used by another program.
_ANSWER_LIMIT_S = 2.0


@dataclass(frozen=True, slots=True)
class UsedMaster:
    """The environment to join with, a line for users about its master, and whether we started that master."""

    environment: RosEnvironment
    line: str
    is_ours: bool = False


@asynccontextmanager
async def used_master(
    environment: RosEnvironment, *, is_chosen: bool = False, port: int | None = None
) -> AsyncIterator[UsedMaster]:
    """Find the master to use; if there is none, run one until the end of the block.

    `is_chosen` is true if the user named it (`--master`); `port` is the port of a new one (`--master-port`).
    Raises GraphError if another program uses the port.
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
        # Another program took the port in the meantime; join it if it is a master.
        if not await master_answers(environment):
            raise
        yield UsedMaster(environment, f"Joining the ROS master at {environment.master_uri}")
        return
    try:
        line = f"Started a ROS master: ROS_MASTER_URI={core.uri.rstrip('/')}"
        yield UsedMaster(environment, line, is_ours=True)
    finally:
        await core.close()


async def master_answers(environment: RosEnvironment) -> bool:
    """Return whether a ROS master answers at the environment's URI."""
    client = MasterClient(environment.master_uri, "/rostether")
    try:
        async with asyncio.timeout(_ANSWER_LIMIT_S):
            await client.get_pid()
    except (MasterUnreachableError, TimeoutError):
        return False
    finally:
        await client.close()
    return True
