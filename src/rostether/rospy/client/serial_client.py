"""rosserial_python.SerialClient and RosSerialServer: boards whose topics belong to the program's own node."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Mapping
from typing import Any, cast

from rostether.bridge.supervisor import Supervisor
from rostether.graph.ports import Graph, Level
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.loopback import LOOPBACK
from rostether.rospy.client.exceptions import ROSInterruptException
from rostether.rospy.client.logs import TerminalHandler
from rostether.rospy.client.message_types import all_types
from rostether.rospy.client.node import node, require_running
from rostether.rospy.client.shutdown import is_shutdown_requested, shutdown
from rostether.serde.store import TypeStore
from rostether.transports.address import DEFAULT_BAUD, DEFAULT_PORT, Address, SerialAddress, TcpAddress

# As in rosserial_python.
_DEFAULT_DEVICE = "/dev/ttyUSB0"

# How long the end of the program waits until the boards have been asked to stop.
_CLOSE_LIMIT_S = 3.0

# How long a call waits for the shutdown that has ended it.
_SHUTDOWN_LIMIT_S = 5.0


class SerialClient:
    """Serves the board on a serial port; `timeout` and `fix_pyserial_for_test` have no effect."""

    def __init__(
        self,
        port: str | None = None,
        baud: int = DEFAULT_BAUD,
        timeout: float = 5.0,
        fix_pyserial_for_test: bool = False,
    ) -> None:
        if port is not None and not isinstance(port, str):
            raise TypeError(f"SerialClient takes the name of a serial port, not a {type(port).__name__}")
        self.port: str = port or _DEFAULT_DEVICE
        self.baud: int = int(baud)
        self.timeout: float = timeout

    def run(self) -> None:
        """Serve the board until the node shuts down. If the port is missing, wait for it."""
        _serve(SerialAddress(self.port, self.baud, name=node.graph.node_name))


class RosSerialServer:
    """Serves boards that connect over TCP from this machine; `fork_server` has no effect."""

    def __init__(self, tcp_portnum: int = DEFAULT_PORT, fork_server: bool = False) -> None:
        self.tcp_portnum: int = int(tcp_portnum)
        self.fork_server: bool = fork_server

    def listen(self) -> None:
        """Serve boards until the node shuts down. Raises TransportOpenError if the port is in use."""
        _Terminal().report(
            Level.INFO,
            f"port {self.tcp_portnum} accepts boards on this machine only; for boards on the network use "
            f"`rostether serial-node tcp {self.tcp_portnum} --listen 0.0.0.0`",
        )
        _serve(TcpAddress(LOOPBACK, self.tcp_portnum, name=node.graph.node_name))


class _Terminal:
    """Prints the bridge's lines as rospy prints log lines; the board's node publishes them on /rosout."""

    def __init__(self) -> None:
        self._handler = TerminalHandler()

    def report(self, level: Level, text: str, *, node: str = "") -> None:
        """Print a line."""
        record = logging.LogRecord("rosout", level.number_in_tens, __file__, 0, text, None, None, "run")
        self._handler.emit(record)


class _OwnGraph:
    """The program's graph, which a session of a board cannot close: a session closes its graph at its end."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def __getattr__(self, name: str) -> Any:
        return getattr(self._graph, name)

    async def close(self) -> None:
        """Do nothing: the program still uses the graph."""


def _serve(address: Address) -> None:
    require_running()
    with contextlib.suppress(ROSInterruptException):
        node.call(_serve_until_shutdown(address))
    if is_shutdown_requested():
        # The boards end before is_shutdown() becomes true: a program that checks it now would serve again.
        shutdown.event.wait(_SHUTDOWN_LIMIT_S)


async def _serve_until_shutdown(address: Address) -> None:
    async def join(
        node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        return cast("Graph", _OwnGraph(node.graph))

    supervisor = Supervisor(join, TypeStore(all_types().registry), reporter=_Terminal())

    def close(_: str) -> None:
        with contextlib.suppress(TimeoutError):
            node.loop.call(supervisor.close(), timeout_s=_CLOSE_LIMIT_S)

    shutdown.add_early(close)
    async with closed_at_end(supervisor):
        await supervisor.start([address])
        await supervisor.wait_done()
