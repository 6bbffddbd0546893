"""Relays one action between ROS 1, where it is five topics, and ROS 2, where it is services and topics."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import AsyncExitStack

from msgspec import Struct

from rostether.errors import ServiceUnavailableError
from rostether.graph.ports import Graph, Snapshot
from rostether.msgdef.ros2.action_parts import SEND_GOAL
from rostether.ros2.actions.board_action import BoardAction
from rostether.ros2.actions.board_graph import BoardJoin
from rostether.ros2.actions.ros1_form import CANCEL, FEEDBACK, GOAL, RESULT, STATUS, ActionForms, type_of_part
from rostether.ros2.actions.ros1_server import Ros1ActionServer
from rostether.ros2.actions.types import SEND_GOAL_SERVICE

# The relay's node in ROS 2 that offers and calls actions has the relay's name with this suffix.
NODE_SUFFIX = "_actions"

# How often the ROS 1 server is checked; a client notices its end after this time.
CHECK_S = 1.0


class ActionEntry(Struct, frozen=True):
    """An action in a snapshot: its type as `package/Name`, and the nodes that serve it.

    The node of a relay has the relay's name here, without `NODE_SUFFIX`.
    """

    type: str
    servers: tuple[str, ...]


def action_entries(ros1: Snapshot, ros2: Snapshot) -> tuple[dict[str, ActionEntry], dict[str, ActionEntry]]:
    """Return the actions in ROS 1 and those in ROS 2, by name."""
    return dict(_of_ros1(ros1)), dict(_of_ros2(ros2))


def _of_ros1(snapshot: Snapshot) -> Iterator[tuple[str, ActionEntry]]:
    # A server subscribes to goals, and publishes results.
    for topic, result in snapshot.topics.items():
        name = topic.removesuffix(RESULT[0])
        goal = snapshot.topics.get(name + GOAL[0])
        if name == topic or goal is None or not result.type.endswith(RESULT[1]):
            continue
        servers = tuple(node for node in result.publishers if node in goal.subscribers)
        if servers:
            yield name, ActionEntry(result.type.removesuffix(RESULT[1]), servers)


def _of_ros2(snapshot: Snapshot) -> Iterator[tuple[str, ActionEntry]]:
    for service_name, service in snapshot.services.items():
        name = service_name.removesuffix(f"/{SEND_GOAL_SERVICE}")
        if name != service_name and service.type.endswith(SEND_GOAL):
            type_name = service.type.removesuffix(SEND_GOAL).replace("/action/", "/")
            servers = tuple(node.removesuffix(NODE_SUFFIX) for node in service.providers)
            yield name, ActionEntry(type_name, servers)


class ActionRelay:
    """Offers an action of one graph in the other one, from `open` to `close`.

    `type_name` is `package/Name`, and `ros1` the relay's node in ROS 1, where the server is with `to_ros2`.
    """

    def __init__(self, name: str, type_name: str, ros1: Graph, join: BoardJoin, *, to_ros2: bool) -> None:
        self.type_name = type_name
        self._name = name
        self._ros1 = ros1
        self._join = join
        self._to_ros2 = to_ros2
        self._stack = AsyncExitStack()

    async def open(self) -> None:
        """Offer the action; with `to_ros2`, wait for a server in ROS 1 first. Raises RostetherError."""
        session = await self._join.session()
        native = await session.join(self._ros1.node_name + NODE_SUFFIX)
        self._stack.push_async_callback(native.close)
        types = self._join.types
        if not self._to_ros2:
            forms = ActionForms(self.type_name, types, session.types)
            server = Ros1ActionServer(
                self._name, self.type_name, forms, ros1=self._ros1, native=native, registry=types.registry
            )
            await server.open()
            self._stack.push_async_callback(server.close)
            return
        action = BoardAction(self._name, self.type_name, types)
        await self._connect(action)
        await action.open(native, session.types)
        self._stack.push_async_callback(action.close)

    async def wait_for_new_type(self) -> None:
        """Wait until a server in ROS 1 has ended, then raise ServiceUnavailableError.

        If the server is in ROS 2, wait without end.
        """
        # The port does not report connections, and polling is cheap.
        while not self._to_ros2 or self._is_served():  # noqa: ASYNC110
            await asyncio.sleep(CHECK_S)
        raise ServiceUnavailableError(f"its server in ROS 1 has ended; waiting for {self._name}")

    async def close(self) -> None:
        """Stop, and cancel or abort the active goals. Raises GraphError."""
        await self._stack.aclose()

    async def _connect(self, action: BoardAction) -> None:
        """Connect to the server's topics in ROS 1."""
        type_of = self._join.types.registry.message_type
        graph, name = self._ros1, self._name
        self._goals = await graph.advertise(name + GOAL[0], type_of(self.type_name + GOAL[1]))
        self._stack.push_async_callback(self._goals.close)
        cancels = await graph.advertise(name + CANCEL[0], type_of(CANCEL[1]))
        self._stack.push_async_callback(cancels.close)
        action.on_goals, action.on_cancels = self._goals.publish_raw, cancels.publish_raw
        subscribers = []
        for part, handler in (
            (FEEDBACK, action.handle_feedback),
            (STATUS, action.handle_statuses),
            (RESULT, action.handle_results),
        ):
            message_type = type_of(type_of_part(part, self.type_name))
            subscribers.append(await graph.subscribe(name + part[0], message_type, handler, skip_own=True))
            self._stack.push_async_callback(subscribers[-1].close)
        self._results = subscribers[-1]
        while not (self._is_served() and cancels.subscriber_count and subscribers[0].publisher_count):  # noqa: ASYNC110
            await asyncio.sleep(CHECK_S / 10)

    def _is_served(self) -> bool:
        return self._goals.subscriber_count > 0 and self._results.publisher_count > 0
