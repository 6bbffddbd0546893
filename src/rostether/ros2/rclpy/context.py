"""One rclpy context for all nodes of a process: one participant on the network, and a thread for each node.

After each event, rclpy checks everything that a thread waits for. With one thread per node, a board's latency
does not grow with the number of boards.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from typing import Any

from rostether.errors import GraphError
from rostether.names.graph_name import join, validate_name
from rostether.ros2.rclpy.executor_thread import ExecutorThread
from rostether.ros2.rclpy.failures import attempt
from rostether.ros2.rclpy.graph import RclpyGraph
from rostether.ros2.rclpy.installation import load_rclpy
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.types.type_support import Ros2Types


class RclpyContext:
    """Opens nodes on a ROS 2 graph through rclpy and its installed middleware.

    rclpy and the middleware read other settings from the environment of the process: RMW_IMPLEMENTATION,
    ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS, and the middleware's own variables.
    """

    def __init__(self, context: Any, types: Ros2Types, arguments: Sequence[str]) -> None:
        self._context = context
        self.types = types
        self._arguments = arguments
        self._graphs: set[RclpyGraph] = set()
        # Nodes are created one after the other: rcl's context is not thread-safe.
        self._lock = asyncio.Lock()
        self._is_closed = False

    @classmethod
    async def open(cls, types: Ros2Types, *, domain_id: int, arguments: Sequence[str] = ()) -> RclpyContext:
        """Start rclpy in a domain.

        `arguments` are passed to every node, such as `["--ros-args", "--params-file", "a.yaml"]`.
        Raises ConfigError if rclpy is not installed, GraphError if it does not start.
        """
        rclpy = await asyncio.to_thread(load_rclpy)
        context = rclpy.context.Context()
        attempt("start rclpy", lambda: context.init(args=[], domain_id=domain_id))
        return cls(context, types, list(arguments))

    async def join(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> RclpyGraph:
        """Join as `node_name`; another node with this name may exist. Raises InvalidNameError, GraphError."""
        full_name = join(namespace, validate_name(node_name))
        if self._is_closed:
            raise GraphError("rclpy has been shut down; open it again")
        thread = ExecutorThread(self._context)
        try:
            async with self._lock:
                own = await thread.run(
                    lambda: OwnNode(
                        full_name,
                        context=self._context,
                        thread=thread,
                        types=self.types,
                        arguments=self._arguments,
                    )
                )
        except BaseException:
            await thread.stop()
            raise
        graph = RclpyGraph(own, namespace, remappings or {}, on_close=self._graphs.discard)
        self._graphs.add(graph)
        return graph

    async def close(self) -> None:
        """Leave with all nodes, and end rclpy. Idempotent."""
        if self._is_closed:
            return
        self._is_closed = True
        await asyncio.gather(*(graph.close() for graph in list(self._graphs)))
        await asyncio.to_thread(self._end)

    def _end(self) -> None:
        attempt("end rclpy", self._context.try_shutdown)
        attempt("end rclpy", self._context.destroy)
