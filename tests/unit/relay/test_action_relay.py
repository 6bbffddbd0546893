"""Actions through a ROS 2 graph, a ROS 1 graph and another ROS 2 graph, with a relay between each two."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, nullcontext
from functools import partial

import pytest

from contract.graphs import Inbox
from rostether.errors import SerializationError, UnknownTypeError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Level
from rostether.msgdef.interface import ServiceType
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.relay.action_relay import CHECK_S
from rostether.relay.relay import Relay
from rostether.relay.relay_filter import RelayFilter, ServiceFilter, TopicFilter
from rostether.relay.side import RelaySide
from rostether.ros2.actions.board_graph import BoardJoin, NativeSession
from rostether.ros2.actions.ros1_form import (
    ActionForms,
    GoalId,
    Ros1Status,
    after_header,
    read_status,
    read_statuses,
    write_header,
    write_statuses,
)
from rostether.ros2.actions.server import Ros2ActionServer
from rostether.ros2.actions.types import GoalCall, GoalStatus
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import Ros2Types
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from unit.bridge.virtual_time import on_virtual_time

# Its goal has a Header and a pose, whose layouts differ in ROS 1 and ROS 2.
ACTION, TYPE = "/arm/reach", "move_base_msgs/MoveBase"
REGISTRY = Registry()
NATIVE = NativeRegistry.from_environment(environ={})
# ROS 2 has no definition of this type, so it uses that of ROS 1.
FORMS = ActionForms(TYPE, Ros2Types(REGISTRY, Ros2Definitions()), NativeTypes(NATIVE))


async def no_service(service: str, name: str) -> ServiceType:
    raise UnknownTypeError(f"no definition of {name}, the type of {service}")


def open_session(session: NativeSession) -> nullcontext[NativeSession]:
    return nullcontext(session)


class Server:
    """Serves the action in ROS 2; `goals` and `cancels` are the received requests."""

    def __init__(self) -> None:
        self.goals: list[tuple[bytes, bytes]] = []
        self.cancels: list[bytes] = []
        self.action = Ros2ActionServer(
            ACTION,
            FORMS.types,
            empty_result=FORMS.empty_result,
            on_goal=lambda goal_id, payload: self.goals.append((goal_id, payload)),
            on_cancel=self.cancels.append,
        )


async def eventually(check: object) -> None:
    """Wait in virtual time until a list has an element."""
    async with asyncio.timeout(60):
        while not check:
            await asyncio.sleep(0.01)


class Chain:
    """The three graphs, and the lines that the relays report."""

    def __init__(self) -> None:
        self.networks = [MemoryNetwork() for _ in range(3)]
        self.lines: list[str] = []
        self.server = Server()
        self.store = TypeStore(NATIVE)

    @asynccontextmanager
    async def relaying(self) -> AsyncIterator[GoalCall]:
        """Run the relays until the end of the block, and yield a call of the action."""
        near, ros1, far = self.networks
        await self.server.action.open(await near.join("/server"))
        joins, running = [], []
        for number, ros2 in enumerate((near, far)):
            name = f"/relay_{number}"
            session = NativeSession(ros2.join, NativeTypes(NATIVE))
            types = Ros2Types(REGISTRY, Ros2Definitions())
            joins.append(BoardJoin(ros2.join, types, partial(open_session, session)))
            relay = Relay(
                RelaySide("ROS 1", await ros1.join(name), no_service),
                RelaySide("ROS 2", await ros2.join(name), no_service),
                RelayFilter((TopicFilter("*"),), (ServiceFilter("*"),), (ACTION,)),
                self.report,
                joins[-1],
            )
            running.append(asyncio.create_task(relay.run()))
        async with asyncio.timeout(60):
            while f"{ACTION}/_action/get_result" not in far.snapshot().services:
                await asyncio.sleep(0.01)
        yield GoalCall(await far.join("/client"), ACTION, FORMS.types)
        for task in running:
            task.cancel()
        await asyncio.gather(*running, return_exceptions=True)
        for join in joins:
            await join.close()

    def report(self, _: Level, line: str) -> None:
        self.lines.append(line)


@on_virtual_time
async def test_a_goal_has_feedback_and_a_result_in_every_graph() -> None:
    chain, arrived = Chain(), Inbox()
    async with chain.relaying() as call:
        target = {"header": {"frame_id": "map"}, "pose": {"position": {"x": 1.5}}}
        goal = chain.store.codec("move_base_msgs/MoveBase_Goal").encode({"target_pose": target})
        running = asyncio.create_task(call.run(goal, lambda payload: arrived.store([payload])))
        await eventually(chain.server.goals)
        goal_id, received = chain.server.goals.pop()
        assert received == goal
        position = {"base_position": {"header": {"frame_id": "odom"}}}
        feedback = chain.store.codec("move_base_msgs/MoveBase_Feedback").encode(position)
        chain.server.action.feedback(goal_id, feedback)
        await eventually(arrived.payloads)
        chain.server.action.finish(goal_id, GoalStatus.SUCCEEDED)
        assert await running == (GoalStatus.SUCCEEDED, b"")
        assert arrived.payloads == [feedback]
        assert f"relaying action {ACTION} from ROS 2 to ROS 1 ({TYPE})" in chain.lines
        assert f"relaying action {ACTION} from ROS 1 to ROS 2 ({TYPE})" in chain.lines
        # The topics and services of a relayed action are not relayed one by one.
        assert not [line for line in chain.lines if ACTION in line and f"action {ACTION}" not in line]


@on_virtual_time
async def test_a_goal_is_canceled_in_every_graph() -> None:
    chain = Chain()
    async with chain.relaying() as call:
        goal = chain.store.codec("move_base_msgs/MoveBase_Goal").encode({})
        running = asyncio.create_task(call.run(goal))
        await eventually(chain.server.goals)
        await call.cancel()
        await eventually(chain.server.cancels)
        chain.server.action.finish(chain.server.cancels[0], GoalStatus.CANCELED)
        assert (await running)[0] is GoalStatus.CANCELED


@on_virtual_time
async def test_a_goal_is_aborted_when_its_server_ends() -> None:
    chain = Chain()
    async with chain.relaying() as call:
        goal = chain.store.codec("move_base_msgs/MoveBase_Goal").encode({})
        running = asyncio.create_task(call.run(goal))
        await eventually(chain.server.goals)
        await chain.networks[0].nodes["/server"].close()
        async with asyncio.timeout(60):
            assert (await running)[0] is GoalStatus.ABORTED
        await asyncio.sleep(2 * CHECK_S)
        assert f"{ACTION}/goal" not in chain.networks[1].snapshot().topics


def test_a_message_of_ros1_that_ends_early_is_refused() -> None:
    status = GoalId((1, 2), "a").status(Ros1Status.ACTIVE, "")
    feedback = write_header(Time(3, 4)) + status
    assert read_status(feedback, after_header(feedback)) == ("a", Ros1Status.ACTIVE, len(feedback))
    for size in range(len(feedback)):
        with pytest.raises(SerializationError):
            read_status(feedback[:size], after_header(feedback[:size]))
    statuses = write_statuses(Time(3, 4), [status])
    assert read_statuses(statuses) == {"a"}
    for size in range(len(statuses)):
        with pytest.raises(SerializationError):
            read_statuses(statuses[:size])
