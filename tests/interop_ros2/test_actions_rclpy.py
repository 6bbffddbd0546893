"""A board's action, used by an action client of rclpy."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from interop_ros2.rclpy_peer import RclpyPeer
from ros2_domains import own_domain
from rostether.bridge.supervisor import Supervisor
from rostether.device.device import Device
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.actions.board_graph import BoardJoin, NativeSession
from rostether.ros2.rclpy.context import RclpyContext
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import Ros2Types
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from rostether.transports.address_parser import parse_address
from unit.bridge.doubles import RecordingReporter
from waiting import until

pytestmark = [pytest.mark.rclpy, pytest.mark.asyncio(loop_scope="module")]

TYPE = "test_msgs/Fibonacci"
SUCCEEDED = 4


class CountingBoard:
    """Serves the action `count`: feedback with all numbers except the last, and a result with all."""

    def __init__(self, device: Device) -> None:
        self._feedback = device.publisher("count/feedback", f"{TYPE}ActionFeedback")
        self._result = device.publisher("count/result", f"{TYPE}ActionResult")
        device.publisher("count/status", "actionlib_msgs/GoalStatusArray")
        device.subscriber("count/cancel", "actionlib_msgs/GoalID", lambda _: None)
        device.subscriber("count/goal", f"{TYPE}ActionGoal", self._begin)

    def _begin(self, message: Message) -> None:
        numbers = [0, 1]
        while len(numbers) <= message.goal.order:
            numbers.append(numbers[-1] + numbers[-2])
        status = {"goal_id": {"id": message.goal_id.id}, "status": 1}
        self._feedback.publish(status=status, feedback={"sequence": numbers[:-1]})
        self._result.publish(status={**status, "status": 3}, result={"sequence": numbers})


@contextlib.asynccontextmanager
async def native_session(folder: Path) -> AsyncIterator[NativeSession]:
    types = NativeTypes(NativeRegistry.from_environment([folder]))
    context = await RclpyContext.open(types, domain_id=own_domain())
    try:
        yield NativeSession(context.join, types)
    finally:
        await context.close()


async def test_rclpy_sends_a_goal_to_a_board(context: RclpyContext, peer: RclpyPeer, tmp_path: Path) -> None:
    if find_spec("test_msgs") is None:
        pytest.skip("test_msgs is not installed: pip install ros-test-msgs")
    file = tmp_path / "test_msgs" / "action" / "Fibonacci.action"
    file.parent.mkdir(parents=True)
    file.write_text("int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n")
    store = TypeStore(Registry([tmp_path]))
    join = BoardJoin(
        context.join, Ros2Types(store.registry, Ros2Definitions()), lambda: native_session(tmp_path)
    )
    supervisor = Supervisor(join, store, reporter=RecordingReporter())
    try:
        await supervisor.start([parse_address("tcp://127.0.0.1:0?name=counter")])
        device = Device(supervisor.listening_on[0], store=store)
        CountingBoard(device)
        async with device:
            await until(
                lambda: supervisor.boards() and len(supervisor.boards()[0].endpoints) == 5, "the board"
            )
            answer = await peer.ask(
                "send_goal", action="/count", type="test_msgs/action/Fibonacci", goal={"order": 5}
            )
            assert answer["status"] == SUCCEEDED
            assert answer["result"] == {"sequence": [0, 1, 1, 2, 3, 5]}
            # If rclpy receives the feedback after the result, it drops the feedback.
            assert answer["feedback"] in ([], [{"sequence": [0, 1, 1, 2, 3]}])
    finally:
        await supervisor.close()
        await asyncio.wait_for(join.close(), 60)
