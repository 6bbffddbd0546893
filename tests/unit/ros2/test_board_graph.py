"""A board's action of ROS 1 topics, seen by a ROS 2 action client, on graphs in memory."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, nullcontext
from typing import Any

import pytest

from rostether.errors import DefinitionError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Graph, Publisher
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.actions.board_action import LOST_AFTER_S
from rostether.ros2.actions.board_graph import BoardJoin, NativeSession
from rostether.ros2.actions.types import ActionTypes, GoalCall, GoalStatus
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import Ros2Types
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from unit.bridge.virtual_time import on_virtual_time

# Its goal has a Header and a pose, whose layouts differ in ROS 1 and ROS 2.
ACTION, TYPE = "/arm/reach", "move_base_msgs/MoveBase"
STORE = TypeStore(Registry())


class Board:
    """A board that serves the action; `goals` and `cancels` are the received requests."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.goals: list[Message] = []
        self.cancels: list[str] = []
        self._publishers: dict[str, Publisher] = {}

    async def open(self) -> None:
        """Declare the five topics in the order of the sketch: the status first."""
        for part, name in (
            ("status", "actionlib_msgs/GoalStatusArray"),
            ("feedback", f"{TYPE}ActionFeedback"),
            ("result", f"{TYPE}ActionResult"),
        ):
            self._publishers[part] = await self.graph.advertise(
                f"{ACTION}/{part}", STORE.registry.message_type(name)
            )
        goal, cancel = STORE.codec(f"{TYPE}ActionGoal"), STORE.codec("actionlib_msgs/GoalID")
        # The bridge subscribes to cancels while the action is opened.
        await asyncio.gather(
            self.graph.subscribe(
                f"{ACTION}/goal",
                STORE.registry.message_type(f"{TYPE}ActionGoal"),
                lambda payloads: self.goals.extend(map(goal.decode, payloads)),
            ),
            self.graph.subscribe(
                f"{ACTION}/cancel",
                STORE.registry.message_type("actionlib_msgs/GoalID"),
                lambda payloads: self.cancels.extend(cancel.decode(each).id for each in payloads),
            ),
        )

    def send(self, part: str, goal: Message, status: int, **fields: Any) -> None:
        """Publish feedback or a result about a goal."""
        values = {"status": {"goal_id": {"id": goal.goal_id.id}, "status": status}, part: fields}
        publisher = self._publishers[part]
        publisher.publish_raw([STORE.codec(publisher.type.name).encode(values)])

    def send_status(self, *goals: Message) -> None:
        """Publish the goals that the board knows."""
        values = {"status_list": [{"goal_id": {"id": each.goal_id.id}, "status": 1} for each in goals]}
        self._publishers["status"].publish_raw([STORE.codec("actionlib_msgs/GoalStatusArray").encode(values)])


@asynccontextmanager
async def a_stage() -> AsyncIterator[tuple[Board, GoalCall, TypeStore, NativeSession]]:
    """Yield a board, and a call to its action from a client."""
    registry = NativeRegistry.from_environment(environ={})
    types = NativeTypes(registry)
    network = MemoryNetwork()

    async def join_slowly(node_name: str, *, namespace: str = "/", **_: Any) -> Graph:
        await asyncio.sleep(0.01)
        return await network.join(node_name, namespace=namespace)

    session = NativeSession(join_slowly, types)
    join = BoardJoin(network.join, Ros2Types(STORE.registry, Ros2Definitions()), lambda: nullcontext(session))
    board = Board(await join("arm"))
    await board.open()
    client = await network.join("client")
    call = GoalCall(client, ACTION, ActionTypes.find(registry, TYPE))
    yield board, call, TypeStore(registry), session
    await board.graph.close()
    await client.close()
    await join.close()


async def goal_of(board: Board) -> Message:
    """Wait for a goal."""
    while not board.goals:
        await asyncio.sleep(0.01)
    return board.goals.pop()


@on_virtual_time
async def test_a_goal_has_feedback_and_a_result() -> None:
    async with a_stage() as (board, call, store, _):
        arrived: list[bytes] = []
        target = {"header": {"frame_id": "map"}, "pose": {"position": {"x": 1.5}}}
        goal = store.codec("move_base_msgs/MoveBase_Goal").encode({"target_pose": target})
        running = asyncio.create_task(call.run(goal, arrived.append))
        received = await goal_of(board)
        assert received.goal_id.id == call.goal_id.hex()
        assert received.goal.target_pose.header.frame_id == "map"
        assert received.goal.target_pose.pose.position.x == 1.5
        board.send("feedback", received, 1, base_position={"header": {"seq": 7, "frame_id": "odom"}})
        board.send("result", received, 3)
        assert await running == (GoalStatus.SUCCEEDED, b"")
        (feedback,) = map(store.codec("move_base_msgs/MoveBase_Feedback").decode, arrived)
        assert feedback.base_position.header.frame_id == "odom"
        # The topics of the action are not in the graph; a message about a finished goal changes nothing.
        board.send("result", received, 4)
        assert not [each for each in (await board.graph.snapshot()).topics if each.endswith("/goal")]


@on_virtual_time
async def test_goals_are_canceled_replaced_and_lost() -> None:
    async with a_stage() as (board, call, store, _):
        goal = store.codec("move_base_msgs/MoveBase_Goal").encode({})
        running = asyncio.create_task(call.run(goal))
        received = await goal_of(board)
        await call.cancel()
        await asyncio.sleep(0.01)
        assert board.cancels == [received.goal_id.id]
        board.send("result", received, 2)
        assert (await running)[0] is GoalStatus.CANCELED
        # A goal that another one has replaced was not canceled by its client.
        call.goal_id = bytes(range(16))
        running = asyncio.create_task(call.run(goal))
        board.send("result", await goal_of(board), 2)
        assert (await running)[0] is GoalStatus.ABORTED
        # A board that was reset no longer lists the goal.
        call.goal_id = bytes(range(1, 17))
        running = asyncio.create_task(call.run(goal))
        received = await goal_of(board)
        board.send_status(received)
        await asyncio.sleep(LOST_AFTER_S + 1)
        board.send_status(received)
        await asyncio.sleep(0.01)
        assert not running.done()
        board.send_status()
        assert (await running)[0] is GoalStatus.ABORTED


@on_virtual_time
async def test_an_action_of_another_definition_is_refused() -> None:
    async with a_stage() as (_, _, _, session):
        own = Registry(bundled=False)
        for part in ("Goal", "Result", "Feedback"):
            own.add_full_text(f"example_interfaces/Fibonacci{part}", "int64 order\n")
        own.add_full_text("example_interfaces/FibonacciActionGoal", "int64 order\n")
        join = BoardJoin(
            MemoryNetwork().join, Ros2Types(own, Ros2Definitions()), lambda: nullcontext(session)
        )
        graph = await join("other")
        with pytest.raises(DefinitionError, match=r"Fibonacci_Goal of ROS 2 and of ROS 1 differ"):
            await graph.subscribe(
                "count/goal", own.message_type("example_interfaces/FibonacciActionGoal"), lambda _: None
            )
        await graph.close()
        await join.close()
