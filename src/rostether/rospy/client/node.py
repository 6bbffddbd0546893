"""The node of this process: its graph after init_node, and the functions that wait for the graph."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

from rostether.errors import ConfigError, MasterUnreachableError, RostetherError
from rostether.mechanisms.loop_thread import LoopThread
from rostether.mechanisms.waiting import wait_for_master
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.node import Ros1Graph, join_ros1
from rostether.rospy.client.exceptions import (
    MasterAwayException,
    ROSException,
    ROSInitException,
    ROSInterruptException,
)
from rostether.rospy.client.names import names
from rostether.rospy.client.shutdown import is_shutdown, shutdown

_T = TypeVar("_T")

# How long leaving the graph may delay the end of a program.
LEAVE_TIMEOUT_S = 5.0


class Node:
    """The one node of a process. Its methods may be called from any thread."""

    def __init__(self) -> None:
        self.loop = LoopThread(lambda: ROSInterruptException("rospy shutdown"))
        self.lock = threading.RLock()
        self.is_initialized = False
        self._graph: Ros1Graph | None = None
        self._master: MasterClient | None = None
        self._waiting: list[Callable[[], object]] = []

    @property
    def graph(self) -> Ros1Graph:
        """The graph. Raises ROSInitException before init_node."""
        if self._graph is None:
            raise ROSInitException("client code must call rospy.init_node() first")
        return self._graph

    def call(self, coroutine: Coroutine[Any, Any, _T]) -> _T:
        """Run a coroutine in the node's loop, and return its result.

        Raises MasterAwayException if no master answers, ROSException for an invalid setting, and the other
        errors of the coroutine.
        """
        try:
            return self.loop.call(coroutine)
        except MasterUnreachableError as error:
            raise MasterAwayException(f"{error}") from None
        except ConfigError as error:
            raise ROSException(f"{error}") from None

    def master(self) -> MasterClient:
        """Return a client of the master; before init_node, its caller id is that of an unnamed node.

        Raises ROSInitException.
        """
        with self.lock:
            if self._master is None or self._master.caller_id != names.caller_id:
                self._master = MasterClient(self.environment().master_uri, names.caller_id)
            return self._master

    def environment(self) -> RosEnvironment:
        """Return the settings in environment variables and special arguments. Raises ROSInitException."""
        environ = dict(os.environ)
        mappings = names.mappings
        for key, variable in (
            ("__hostname", "ROS_HOSTNAME"),
            ("__ip", "ROS_IP"),
            ("__master", "ROS_MASTER_URI"),
        ):
            if key in mappings:
                environ[variable] = mappings[key]
        try:
            return RosEnvironment.read(environ)
        except ConfigError as error:
            raise ROSInitException(f"{error}") from None

    def when_joined(self, join: Callable[[], object]) -> None:
        """Run a function that needs the graph: now, or when the node has joined."""
        with self.lock:
            if self._graph is None:
                self._waiting.append(join)
                return
        join()

    def forget(self, join: Callable[[], object]) -> None:
        """Cancel `when_joined` for a function."""
        with self.lock:
            if join in self._waiting:
                self._waiting.remove(join)

    def join(self, full_name: str) -> None:
        """Wait for the master without a limit, then join the graph. Raises ROSInitException."""
        shutdown.add(self._leave)
        try:
            graph = self.loop.call(self._join(full_name, self.environment()))
        except RostetherError as error:
            raise ROSInitException(f"{error}") from None
        with self.lock:
            self._graph = graph
            waiting, self._waiting = self._waiting, []
        for join in waiting:
            join()

    async def _join(self, full_name: str, environment: RosEnvironment) -> Ros1Graph:
        return await wait_for_master(
            lambda: join_ros1(full_name, environment=environment, on_leave=self._asked_to_leave),
            lambda _: sys.stderr.write(
                f"Unable to register with master node [{environment.master_uri}]: "
                "master may not be running yet. Will keep trying.\n"
            ),
        )

    def _asked_to_leave(self, reason: str) -> None:
        # Runs in a thread, because the program's hooks may use the graph, which needs this loop.
        threading.Thread(target=shutdown.signal, args=(reason,), name="rospy shutdown").start()

    def _leave(self, reason: str) -> None:
        self.loop.interrupt()
        if self._graph is not None:
            with contextlib.suppress(Exception):
                self.loop.call(self._graph.close(), timeout_s=LEAVE_TIMEOUT_S)


node = Node()


def is_initialized() -> bool:
    """Return whether init_node has succeeded."""
    return node.is_initialized


def get_node_uri() -> str | None:
    """Return the URI of the node's XML-RPC server; None before init_node."""
    return node.graph.node_uri if node.is_initialized else None


def require_running() -> None:
    """Raise ROSException if the node has not joined yet."""
    if not node.is_initialized and not is_shutdown():
        raise ROSException("ROS node has not been initialized yet. Please call init_node() first")
