from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Any

import pytest

from rostether.gateways.rosbridge.form_source import Style
from rostether.ros2.actions.types import ID_BYTES, GoalStatus
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeClasses
from rostether.serde.store import TypeStore
from unit.gateways.rosbridge.web_client import WebClient, World, world

REGISTRY = NativeRegistry.from_environment(environ={})
STORE = TypeStore(REGISTRY, NativeClasses(REGISTRY))
COUNT = {"action": "/count"}
FIBONACCI = "example_interfaces/action/Fibonacci"


@pytest.fixture
async def there() -> AsyncIterator[World]:
    async with world(store=STORE, style=Style.ROS2) as made:
        yield made


async def send_goal(client: WebClient, goal_id: str = "g1", **more: Any) -> None:
    await client.say(
        "send_action_goal", id=goal_id, **COUNT, action_type=FIBONACCI, args={"order": 3}, **more
    )


async def test_one_client_carries_out_the_goals_of_another(there: World) -> None:
    async with there.client() as robot, there.client() as page:
        # Both spellings of the type, as with messages.
        await robot.say("advertise_action", **COUNT, type="example_interfaces/Fibonacci")
        await robot.settled()
        await send_goal(page, feedback=True)
        goal = await robot.receive("send_action_goal")
        assert (goal["args"], goal["action"]) == ({"order": 3}, "/count")
        await robot.say("action_feedback", **COUNT, id=goal["id"], values={"sequence": [0, 1]})
        assert await page.receive() == {
            "op": "action_feedback",
            "id": "g1",
            "action": "/count",
            "values": {"sequence": [0, 1]},
        }
        values = {"sequence": [0, 1, 1]}
        await robot.say("action_result", **COUNT, id=goal["id"], values=values, status=4, result=True)
        assert await page.receive() == {
            "op": "action_result",
            "id": "g1",
            "action": "/count",
            "values": values,
            "status": GoalStatus.SUCCEEDED,
            "result": True,
        }
        # A goal that is finished has no more results.
        await robot.say("action_result", **COUNT, id=goal["id"], values=values, status=4, result=True)
        assert "has no active goal" in (await robot.receive("status"))["msg"]
        await robot.say("action_feedback", **COUNT, id="x", values={})
        assert 'no goal has the id "x"' in (await robot.receive("status"))["msg"]


async def test_goals_are_canceled_and_fail(there: World) -> None:
    async with there.client() as robot, there.client() as page:
        await robot.say("advertise_action", **COUNT, type=FIBONACCI)
        await robot.settled()
        await send_goal(page)
        goal = await robot.receive("send_action_goal")
        await send_goal(page)
        assert 'the goal "g1" is already active' in (await page.receive("status"))["msg"]
        await page.say("cancel_action_goal", **COUNT, id="g1")
        assert await robot.receive() == {"op": "cancel_action_goal", "id": goal["id"], "action": "/count"}
        values = {"sequence": [0]}
        await robot.say("action_result", **COUNT, id=goal["id"], values=values, status=5, result=True)
        result = await page.receive("action_result")
        assert (result["status"], result["values"], result["result"]) == (GoalStatus.CANCELED, values, True)
        await page.say("cancel_action_goal", **COUNT, id="g1")
        assert 'no goal of this client has the id "g1"' in (await page.receive("status"))["msg"]

        await send_goal(page)
        goal = await robot.receive("send_action_goal")
        await robot.say("action_result", **COUNT, id=goal["id"], status=6, result=False)
        result = await page.receive("action_result")
        assert (result["status"], result["values"]) == (GoalStatus.ABORTED, {"sequence": []})

        # All goals, by the service of ROS 2 itself.
        await send_goal(page)
        goal = await robot.receive("send_action_goal")
        await page.say("call_service", service="/count/_action/cancel_goal", args={})
        assert (await robot.receive("cancel_action_goal"))["id"] == goal["id"]
        canceling = (await page.receive("service_response"))["values"]
        assert (canceling["return_code"], len(canceling["goals_canceling"])) == (0, 1)
        await robot.say("unadvertise_action", **COUNT)
        assert (await page.receive("action_result"))["status"] == GoalStatus.ABORTED
        await robot.say("unadvertise_action", **COUNT)
        assert "does not offer /count" in (await robot.receive("status"))["msg"]


async def test_the_goals_of_a_client_that_leaves_are_canceled(there: World) -> None:
    async with there.client() as robot:
        await robot.say("advertise_action", **COUNT, type=FIBONACCI)
        await robot.settled()
        async with there.client() as page:
            await send_goal(page)
            goal = await robot.receive("send_action_goal")
        assert (await robot.receive("cancel_action_goal"))["id"] == goal["id"]
        assert len(bytes.fromhex(goal["id"].rpartition(":")[2])) == ID_BYTES
    async with there.client() as page:
        await send_goal(page)
        result = await page.receive("action_result")
        assert (result["result"], result["status"]) == (False, GoalStatus.UNKNOWN)
        assert "/count/_action/send_goal" in result["values"]


async def test_goals_that_cannot_be_sent(there: World) -> None:
    async with there.client() as page:
        await page.say("send_action_goal", **COUNT, action_type="far_msgs/action/Odd")
        assert "no ROS 2 package 'far_msgs' is known" in (await page.receive("status"))["msg"]
        await page.say("send_action_goal", **COUNT, action_type=FIBONACCI, args={"odr": 3})
        assert "odr" in (await page.receive("status"))["msg"]
    async with world() as ros1, ros1.client() as page:
        await send_goal(page)
        assert "use ROSLIB.ActionClient" in (await page.receive("status"))["msg"]
