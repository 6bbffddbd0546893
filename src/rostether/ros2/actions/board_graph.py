"""Nodes of boards on a ROS 2 graph, where the five topics of an action become one ROS 2 action.

A board that subscribes to `count/goal` [package/CountActionGoal] serves the action `count`. Its topics are
not in the ROS 2 graph, whose nodes do not use them. All other calls go to the board's node.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack
from typing import Any, TypeAlias, cast

from msgspec import Struct

from rostether.graph.ports import Graph, JoinGraph, Level, OnMessages, Publisher, Subscriber
from rostether.msgdef.interface import MessageType
from rostether.ros2.actions.board_action import BoardAction
from rostether.ros2.actions.ros1_form import CANCEL, FEEDBACK, GOAL, RESULT, STATUS
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import Ros2Types


class NativeSession(Struct, frozen=True):
    """A session on the boards' graph that uses native ROS 2 types."""

    join: JoinGraph
    types: NativeTypes


OpenSession: TypeAlias = Callable[[], AbstractAsyncContextManager[NativeSession]]


class BoardJoin:
    """Joins boards to a ROS 2 graph; a `JoinGraph`. The first action opens the session for actions."""

    def __init__(self, join: JoinGraph, types: Ros2Types, open_session: OpenSession) -> None:
        self.types = types
        self._join = join
        self._open_session = open_session
        self._stack = AsyncExitStack()
        self._session: NativeSession | None = None
        self._opening = asyncio.Lock()

    async def __call__(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        """Join as `node_name`. Raises the same errors as `JoinGraph`."""
        graph = await self._join(node_name, namespace=namespace, remappings=remappings)
        return cast(Graph, _BoardGraph(graph, self))

    async def session(self) -> NativeSession:
        """Return the session for actions. Raises GraphError, ConfigError."""
        async with self._opening:
            if self._session is None:
                self._session = await self._stack.enter_async_context(self._open_session())
            return self._session

    async def close(self) -> None:
        """Close the session for actions. Idempotent."""
        await self._stack.aclose()


class _Topics(Struct):
    """The topics of one action; `action` is None until the board subscribes to goals."""

    on_cancels: OnMessages | None = None
    action: BoardAction | None = None
    node: Graph | None = None

    async def close(self) -> None:
        """Stop offering the action."""
        action, self.action = self.action, None
        node, self.node = self.node, None
        if action is not None:
            await action.close()
        if node is not None:
            await node.close()


class _BoardGraph:
    """A board's node; handles only the topics of actions, and passes all other calls to the node."""

    def __init__(self, graph: Graph, join: BoardJoin) -> None:
        self._graph = graph
        self._join = join
        self._actions: dict[str, _Topics] = {}

    def __getattr__(self, name: str) -> Any:
        """Return a member of the wrapped node."""
        return getattr(self._graph, name)

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> Publisher:
        """Advertise like `Graph.advertise`; topics of an action go to the action."""
        name = self._graph.resolve(topic)
        for part, handle in (
            (FEEDBACK, BoardAction.handle_feedback),
            (RESULT, BoardAction.handle_results),
            (STATUS, BoardAction.handle_statuses),
        ):
            if _is_part(part, name, message_type):
                return _ActionPublisher(name, message_type, self._topics(part, name), handle)
        return await self._graph.advertise(topic, message_type, latch=latch, queue_bytes=queue_bytes)

    async def subscribe(
        self, topic: str, message_type: MessageType, on_messages: OnMessages, **options: Any
    ) -> Subscriber:
        """Subscribe like `Graph.subscribe`; the topic of goals opens an action.

        Also raises DefinitionError, ConfigError.
        """
        name = self._graph.resolve(topic)
        if _is_part(CANCEL, name, message_type):
            topics = self._topics(CANCEL, name)
            topics.on_cancels = on_messages
            if topics.action is not None:
                topics.action.on_cancels = on_messages
            return _ActionSubscriber(name, topics)
        if _is_part(GOAL, name, message_type):
            topics = self._topics(GOAL, name)
            await self._open(topics, name, message_type, on_messages)
            return _ActionSubscriber(name, topics, is_goal=True)
        return await self._graph.subscribe(topic, message_type, on_messages, **options)

    async def close(self) -> None:
        """Leave the graph with all actions. Idempotent."""
        for topics in self._actions.values():
            await topics.close()
        await self._graph.close()

    async def _open(
        self, topics: _Topics, name: str, message_type: MessageType, on_goals: OnMessages
    ) -> None:
        session = await self._join.session()
        action = BoardAction(
            name.removesuffix(GOAL[0]), message_type.name.removesuffix(GOAL[1]), self._join.types
        )
        await topics.close()
        action.on_goals, action.on_cancels = on_goals, topics.on_cancels
        # The board may subscribe to cancel requests while the action is opened.
        topics.action = action
        try:
            topics.node = await session.join(f"{self._graph.node_name.strip('/').replace('/', '_')}_actions")
            await action.open(topics.node, session.types)
        except BaseException:
            await topics.close()
            raise
        self._graph.log(Level.INFO, f"serves the action {action.action} [{action.action_type}]")

    def _topics(self, part: tuple[str, str], name: str) -> _Topics:
        return self._actions.setdefault(name.removesuffix(part[0]), _Topics())


class _ActionPublisher:
    """Passes the board's messages to its action."""

    subscriber_count = 1
    dropped_count = 0

    def __init__(
        self,
        topic: str,
        message_type: MessageType,
        topics: _Topics,
        handle: Callable[[BoardAction, Sequence[bytes]], None],
    ) -> None:
        self.topic = topic
        self.type = message_type
        self._topics = topics
        self._handle = handle

    def publish_raw(self, payloads: Sequence[bytes]) -> bool:
        """Pass the payloads to the action, if it is offered."""
        if self._topics.action is not None and payloads:
            self._handle(self._topics.action, payloads)
        return True

    async def drained(self, timeout_s: float) -> None:
        """Return immediately: there is no queue."""

    async def close(self) -> None:
        """Do nothing: the action ends with its subscription to goals."""


class _ActionSubscriber:
    """The board's subscription to goals or cancel requests."""

    publisher_count = 1

    def __init__(self, topic: str, topics: _Topics, *, is_goal: bool = False) -> None:
        self.topic = topic
        self._topics = topics
        self._is_goal = is_goal

    def pause(self) -> None:
        """Do nothing: goals are few."""

    def resume(self) -> None:
        """Do nothing, like `pause`."""

    async def close(self) -> None:
        """End the action with its goals, or stop passing on cancel requests."""
        if self._is_goal:
            await self._topics.close()
        else:
            self._topics.on_cancels = None


def _is_part(part: tuple[str, str], name: str, message_type: MessageType) -> bool:
    suffix, type_name = part
    return name.endswith(suffix) and message_type.name.endswith(type_name)
