"""A running ROS master: the Master API on an XML-RPC server, and the calls to the nodes."""

from __future__ import annotations

import asyncio
import logging
import os
from collections.abc import Iterable, Iterator, Sequence

from rostether.mechanisms.loopback import LOOPBACK
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.ros1.admission import ALLOW_ALL, Admission
from rostether.ros1.environment import DEFAULT_MASTER_PORT
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.ros1.long_work import run_in_slices
from rostether.ros1.master.master_api import MasterApi
from rostether.ros1.master.node_calls import PING_INTERVAL_S, NodeCallQueue
from rostether.ros1.xmlrpc_server import XmlRpcServer

# The values that roscore of the last ROS 1 distribution sets, with their trailing newlines.
ROS_DISTRO = "noetic\n"
ROS_VERSION = "1.16.0\n"

_log = logging.getLogger("rostether.ros1.master")


class MasterServer:
    """A ROS master with the parameters of roscore; created by `start`."""

    def __init__(
        self,
        hosts: Sequence[str],
        port: int,
        advertised_host: str,
        admission: Admission,
        limits: GraphLimits,
        own_names: Iterable[str],
    ) -> None:
        self._node_calls = NodeCallQueue(self._drop_gone)
        self.api = MasterApi(self._node_calls, self._stop, limits, self._work_later)
        self._server = XmlRpcServer(
            self.api.dispatch(),
            hosts=hosts,
            port=port,
            advertised_host=advertised_host,
            admission=admission,
            limits=limits,
            own_names=own_names,
        )
        self._stopped = asyncio.Event()
        self._closing: asyncio.Task[None] | None = None
        self._ping_timer: asyncio.TimerHandle | None = None
        self._long_work: set[asyncio.Task[None]] = set()

    @classmethod
    async def start(
        cls,
        hosts: Sequence[str] = (LOOPBACK,),
        port: int = DEFAULT_MASTER_PORT,
        *,
        advertised_host: str = "",
        admission: Admission = ALLOW_ALL,
        limits: GraphLimits = DEFAULT_GRAPH_LIMITS,
        own_names: Iterable[str] = (),
    ) -> MasterServer:
        """Start a master on one or several addresses; port 0 means a free one.

        `advertised_host` is the host in its URI, by default the first address. `own_names` are further names
        of this machine that requests may contain. Raises GraphError if the port is already in use,
        ConfigError if an address does not belong to this machine.
        """
        master = cls(hosts, port, advertised_host or hosts[0], admission, limits, own_names)
        await master._listen()
        return master

    @property
    def uri(self) -> str:
        """The URI that nodes use as ROS_MASTER_URI."""
        return self._server.uri

    async def wait_closed(self) -> None:
        """Wait until the master has been closed, by `close` or by a call of its `shutdown` method."""
        await self._stopped.wait()

    async def close(self) -> None:
        """Stop serving, without notifying the nodes. Idempotent."""
        if self._ping_timer is not None:
            self._ping_timer.cancel()
            self._ping_timer = None
        await cancel_all(*self._long_work)
        await self._server.close()
        await self._node_calls.close()
        self._stopped.set()

    async def _listen(self) -> None:
        for name, value in (
            ("/run_id", _new_run_id()),
            ("/rosdistro", ROS_DISTRO),
            ("/rosversion", ROS_VERSION),
        ):
            self.api.parameters.set(name, value)
        await self._server.start()
        self.api.uri = self._server.uri
        self._ping_later()

    def _stop(self, reason: str) -> None:
        _log.info("the master stops: %s", reason)
        # In a separate task, so that the answer to the request is written first.
        self._closing = asyncio.get_running_loop().create_task(self.close())

    def _work_later(self, steps: Iterator[None]) -> None:
        start_task(self._long_work, run_in_slices(steps))

    def _ping_later(self) -> None:
        self._ping_timer = asyncio.get_running_loop().call_later(PING_INTERVAL_S, self._ping_all)

    def _ping_all(self) -> None:
        apis = {node.api for node in self.api.registrations.nodes.values()}
        self._node_calls.retain(apis)
        self._work_later(self._ping_steps(apis))
        self._ping_later()

    def _ping_steps(self, apis: Iterable[str]) -> Iterator[None]:
        for api in apis:
            self._node_calls.ping(api)
            yield

    def _drop_gone(self, api: str) -> None:
        self._work_later(self._drop_steps(api))

    def _drop_steps(self, api: str) -> Iterator[None]:
        """Drop the nodes of a URI one by one: a hostile program may register thousands."""
        gone = [node.name for node in self.api.registrations.nodes.values() if node.api == api]
        for name in gone:
            node = self.api.registrations.nodes.get(name)
            # Another node may have taken the name in between.
            if node is not None and node.api == api:
                _log.warning(
                    "removed the registrations of %s at %s (connection refused); if it still runs, its "
                    "ROS_IP or ROS_HOSTNAME is wrong",
                    name,
                    api,
                )
                self.api.drop_node(name)
            yield


def _new_run_id() -> str:
    # A random UUID; the import of the module uuid would take a tenth of the process's start.
    digits = os.urandom(16).hex()
    return f"{digits[:8]}-{digits[8:12]}-4{digits[13:16]}-a{digits[17:20]}-{digits[20:]}"
