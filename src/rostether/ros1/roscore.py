"""What roscore starts: a master, and the node /rosout that gathers all logs on /rosout_agg."""

from __future__ import annotations

from collections.abc import Sequence

from rostether.graph.log_message import LOG_TYPE
from rostether.ros1.environment import DEFAULT_MASTER_PORT, RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import Ros1Graph, join_ros1


class Roscore:
    """A master with its log collector; `start` makes one that listens."""

    def __init__(self, master: MasterServer, rosout: Ros1Graph) -> None:
        self._master = master
        self._rosout = rosout

    @classmethod
    async def start(cls, environment: RosEnvironment, *, port: int = DEFAULT_MASTER_PORT) -> Roscore:
        """Start where the environment lets us listen; port 0 takes a free one.

        Raises GraphError when the port is taken, ConfigError when an address is not this machine's.
        """
        master = await MasterServer.start(
            environment.listen_hosts, port, advertised_host=environment.advertised_host
        )
        try:
            rosout = await join_ros1("rosout", environment=environment.with_master(master.uri))
            await _gather_logs(rosout)
        except BaseException:
            await master.close()
            raise
        return cls(master, rosout)

    @property
    def uri(self) -> str:
        """The URI that nodes use as ROS_MASTER_URI."""
        return self._master.uri

    async def wait_closed(self) -> None:
        """Wait until the master has been closed, by `close` or from outside."""
        await self._master.wait_closed()

    async def close(self) -> None:
        """Stop both. Idempotent."""
        await self._rosout.close()
        await self._master.close()


async def _gather_logs(rosout: Ros1Graph) -> None:
    collected = await rosout.advertise("/rosout_agg", LOG_TYPE)

    def forward(payloads: Sequence[bytes]) -> None:
        # Logs never wait for who reads them slowly.
        collected.publish_raw(payloads)

    await rosout.subscribe("/rosout", LOG_TYPE, forward)
