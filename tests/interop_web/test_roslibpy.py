"""roslibpy, with both of its transports, with the rosbridge server."""

from __future__ import annotations

import pytest

from interop_web.graphs import GRAPHS
from interop_web.pages import TIMEOUT_S, read_reports, resume, wait_until, wait_until_served
from interop_web.robot_stage import POSE, robot_stage
from interop_web.web_peers import WebPeers


@pytest.mark.parametrize("transport", ["twisted", "asyncio"])
async def test_a_program_uses_a_robot_as_with_rosbridge_suite(web_peers: WebPeers, transport: str) -> None:
    async with GRAPHS["memory"]() as graph, robot_stage(graph) as stage:
        stage.collect("/from_program", "geometry_msgs/Twist")
        stage.collect("/stamped_from_program", "geometry_msgs/PoseStamped")
        program = await web_peers.start("roslibpy_client.py", str(stage.port), transport)

        await wait_until(program, lambda: "serving" in read_reports(program))
        await wait_until_served(stage, "/from_program/double")
        answer = await stage.talker.call(
            "/from_program/double", "std_srvs/SetBool", {"data": True}, timeout_s=60
        )
        assert (answer.success, answer.message) == (False, "program got True")
        await resume(program)

        await wait_until(program, lambda: "waiting for close" in read_reports(program))
        await stage.stop_server()
        await stage.start_server()
        await program.finish(TIMEOUT_S)

        found = read_reports(program)
        assert found["latched"] == {"data": "kept"}
        assert found["relative"] == {"data": "kept"}
        assert found["nested"] == POSE[graph.style]
        assert found["throttled"] == POSE[graph.style]
        assert found["called"] == {"success": True, "message": "enabled"}
        assert "the motor is missing" in found["refused"]
        assert "needs a bool for field data" in found["misfit"]
        assert found["parameter"] == {"p": 1.5}
        assert found["deleted"] is None
        assert found["topics"] is True
        assert found["topicType"] == "geometry_msgs/PoseStamped"
        assert found["topicsForType"][0] == "/pose"
        assert found["serviceType"] == "std_srvs/SetBool"
        assert found["servicesForType"] == ["/enable"]
        assert found["nodes"] == ["/gateway", "/rosapi", "/talker"]
        assert found["nodeDetails"] == ["/enable", "/fail"]
        assert found["details"] == ["x", "y", "z"]
        assert found["time"] is True
        assert found["action"] == "tool to base"
        assert found["served"] is True
        assert found["reconnected"] == {"data": "kept"}

        twist = stage.received["/from_program"][0]
        assert (twist.linear.x, twist.angular.z) == (1.5, -0.5)
        header = stage.received["/stamped_from_program"][0].header
        assert (header.stamp, header.frame_id) == ((5, 6), "map")
