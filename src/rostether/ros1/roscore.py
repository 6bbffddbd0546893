"""The parts of roscore: a master, and the node /rosout, which collects all logs on /rosout_agg."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Sequence

from rostether.errors import ConfigError, GraphError
from rostether.graph.log_message import LOG_TYPE, ROSOUT
from rostether.ros1.environment import DEFAULT_MASTER_PORT, RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import Ros1Graph, join_ros1
from rostether.ros1.own_host import describe_unknown_host

ROSOUT_AGG = "/rosout_agg"
# `rosnode kill -a` also ends /rosout; roscore starts it again, with a delay in case it is killed repeatedly.
_RESPAWN_PAUSE_S = 1.0

_log = logging.getLogger("rostether.ros1.master")


class Roscore:
    """A master with its log collector; `start` makes one that listens."""

    def __init__(self, master: MasterServer, environment: RosEnvironment) -> None:
        self._master = master
        self._environment = environment.with_master(master.uri)
        self._rosout: Ros1Graph | None = None
        self._keeper: asyncio.Task[None] | None = None

    @classmethod
    async def start(cls, environment: RosEnvironment, *, port: int = DEFAULT_MASTER_PORT) -> Roscore:
        """Start on the environment's addresses; port 0 means a free one.

        Raises GraphError if the port is in use. Raises ConfigError if an address does not belong to this
        machine, or if the advertised host name is unknown.
        """
        master = await MasterServer.start(
            environment.listen_hosts,
            port,
            advertised_host=environment.advertised_host,
            admission=environment.admission,
            limits=environment.limits,
            own_names=environment.own_names,
        )
        core = cls(master, environment)
        try:
            core._rosout = await core._join_rosout()
        except BaseException as error:
            await master.close()
            if isinstance(error.__cause__, socket.gaierror):
                raise ConfigError(describe_unknown_host(environment.advertised_host)) from error
            raise
        core._keeper = asyncio.get_running_loop().create_task(core._keep_rosout(core._rosout))
        return core

    @property
    def uri(self) -> str:
        """The URI that nodes use as ROS_MASTER_URI."""
        return self._master.uri

    async def wait_closed(self) -> None:
        """Wait until the master has been closed, by `close` or by a call of its `shutdown` method."""
        await self._master.wait_closed()

    async def close(self) -> None:
        """Stop the node /rosout and the master. Idempotent."""
        if self._keeper is not None:
            self._keeper.cancel()
            await asyncio.wait((self._keeper,))
        if self._rosout is not None:
            await self._rosout.close()
        await self._master.close()

    async def _join_rosout(self) -> Ros1Graph:
        rosout = await join_ros1("rosout", environment=self._environment)
        try:
            collected = await rosout.advertise(ROSOUT_AGG, LOG_TYPE)

            def forward(payloads: Sequence[bytes]) -> None:
                # Logs never wait for a slow reader.
                collected.publish_raw(payloads)

            await rosout.subscribe(ROSOUT, LOG_TYPE, forward)
        except BaseException:
            await rosout.close()
            raise
        return rosout

    async def _keep_rosout(self, rosout: Ros1Graph) -> None:
        while True:
            reason = await rosout.wait_closed()
            _log.info("/rosout has stopped (%s); starting it again", reason)
            self._rosout = None
            await asyncio.sleep(_RESPAWN_PAUSE_S)
            try:
                self._rosout = rosout = await self._join_rosout()
            except GraphError as error:
                _log.warning("cannot start /rosout again: %s", error)
                return
