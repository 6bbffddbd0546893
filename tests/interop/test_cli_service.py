"""`rostether service` compared with rosservice."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from interop.node_stage import ON_BOTH_MASTERS, Stage, stage_on
from interop.side_by_side import SideBySide
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore

STORE = TypeStore(Registry())

# A service whose response has nested structures, one without fields, and one that fails.
RPC_SERVER = """
import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.srv import GetPlan, GetPlanResponse
from std_srvs.srv import Empty, EmptyResponse, Trigger, TriggerResponse
def plan(request):
    response = GetPlanResponse()
    response.plan.header.frame_id = request.start.header.frame_id
    response.plan.header.stamp = request.goal.header.stamp
    response.plan.poses = [PoseStamped(), request.goal]
    return response
def fail(request):
    raise rospy.ServiceException("the motor is hot")
rospy.init_node("server")
rospy.Service("/plan", GetPlan, plan)
rospy.Service("/server/reset", Empty, lambda request: EmptyResponse())
rospy.Service("/fail", Trigger, fail)
print("ready", flush=True)
rospy.spin()
"""
REQUEST = (
    "{start: {header: {frame_id: map}, pose: {position: {x: 1.5}}}, "
    "goal: {header: {stamp: {secs: 5, nsecs: 6}, frame_id: 'a: b'}}, tolerance: 0.25}"
)


@pytest_asyncio.fixture
async def stage(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Stage]:
    async with stage_on(getattr(request, "param", "rostether's master"), tmp_path) as stage:
        yield stage


async def set_led(request: bytes) -> bytes:
    is_on = STORE.codec("std_srvs/SetBoolRequest").decode(request).data
    return STORE.codec("std_srvs/SetBoolResponse").encode({"success": is_on, "message": "on: ä"})


async def test_listings_print_the_same(stage: Stage) -> None:
    tools = SideBySide(stage.peers)
    board = await stage.join("/board")
    await board.advertise_service("/set_led", STORE.registry.service_type("std_srvs/SetBool"), set_led)
    server = await stage.peers.rospy(RPC_SERVER)
    await server.wait_for("ready")

    listed, with_nodes, info, _, _, found, *_ = await tools.assert_all_same(
        "rosservice",
        ("list",),
        ("list", "-n"),
        ("info", "/plan"),
        ("type", "/set_led"),
        ("uri", "/set_led"),
        ("find", "std_srvs/SetBool"),
        ("node", "/set_led"),
        ("args", "/set_led"),
    )
    assert {"/set_led", "/plan", "/server/get_loggers"} <= set(listed.splitlines())
    assert "/set_led /board\n" in with_nodes
    assert "Args: start goal tolerance\n" in info
    assert found == "/set_led\n"
    assert "did you mean /plan?" in await tools.assert_both_fail("rosservice", "type", "/plann")


async def test_calls_print_the_same(stage: Stage) -> None:
    tools = SideBySide(stage.peers)
    board = await stage.join("/board")
    await board.advertise_service("/set_led", STORE.registry.service_type("std_srvs/SetBool"), set_led)
    server = await stage.peers.rospy(RPC_SERVER)
    await server.wait_for("ready")

    printed, *_ = await asyncio.gather(
        tools.assert_same("rosservice", "call", "set_led", "{data: true}"),
        tools.assert_same("rosservice", "call", "-v", "/plan", REQUEST),
        tools.assert_same("rosservice", "call", "/server/reset"),
        tools.assert_same("rosservice", "call", "/server/get_loggers"),
        # If several documents arrive together, rosservice loses all but the first.
        tools.assert_same("rosservice", "call", "/set_led", stdin="data: true\n---\n"),
    )
    assert printed == 'success: True\nmessage: "on: \\xE4"\n'
    failed, refused, missing = await asyncio.gather(
        tools.assert_both_fail("rosservice", "call", "/fail"),
        tools.assert_both_fail("rosservice", "call", "/set_led", "{dta: true}"),
        tools.assert_both_fail("rosservice", "call", "/nothing_like_it"),
    )
    assert "the motor is hot" in failed
    assert "it has data" in refused
    assert "`rostether service list`" in missing


@pytest.mark.roscpp
@ON_BOTH_MASTERS
async def test_a_roscpp_service(stage: Stage) -> None:
    tools = SideBySide(stage.peers)
    server = await stage.peers.roscpp("serve", "/switch")
    called = await tools.run_rostether("rosservice", "call", "--wait", "/switch", "true")
    assert (called.code, called.err) == (0, "")
    assert await tools.assert_same("rosservice", "call", "switch", "True") == called.out
    assert "/switch /roscpp_peer" in await tools.assert_same("rosservice", "list", "-n", "/switch")
    assert "Type: std_srvs/SetBool\nArgs: data\n" in await tools.assert_same("rosservice", "info", "/switch")
    await server.stop()
