"""roslibjs 1 and 2, in Node, with the rosbridge server."""

from __future__ import annotations

import pytest

from interop_web.graphs import GRAPHS
from interop_web.pages import TIMEOUT_S, read_reports, resume, wait_until, wait_until_served
from interop_web.robot_stage import IMAGE_BYTES, POSE, robot_stage
from interop_web.web_peers import WebPeers
from rostether.ros2.types.native_types import types_of


@pytest.mark.parametrize(("generation", "ros"), [("1", "ros1"), ("2", "ros1"), ("2", "zenoh")])
async def test_a_page_uses_a_robot_as_with_rosbridge_suite(
    web_peers: WebPeers, generation: str, ros: str
) -> None:
    async with GRAPHS[ros]() as graph, robot_stage(graph) as stage:
        parameter = "/page/gain" if ros == "ros1" else "/talker:gain"
        stage.collect("/from_page", "geometry_msgs/Twist")
        stage.collect("/text_from_page", "std_msgs/String")
        stage.collect("/bytes_from_page", "std_msgs/UInt8MultiArray")
        page = await web_peers.start("roslib_client.mjs", generation, stage.url, parameter)

        await wait_until(page, lambda: "serving" in read_reports(page))
        await wait_until_served(stage, "/from_page/double")
        answer = await stage.talker.call(
            "/from_page/double", "std_srvs/SetBool", {"data": True}, timeout_s=60
        )
        assert (answer.success, answer.message) == (False, "page got true")
        await resume(page)

        await wait_until(page, lambda: "waiting for close" in read_reports(page))
        await stage.stop_server()
        await stage.start_server()
        await page.finish(TIMEOUT_S)

        found = read_reports(page)
        pose = POSE[graph.style]
        payload = stage.payload("geometry_msgs/PoseStamped", pose)
        if ros == "zenoh":
            pose_type = graph.store.registry.message_type("geometry_msgs/PoseStamped")
            payload = types_of(graph.store.registry).message(pose_type).converter.to_cdr(payload)
        assert found["latched"] == {"data": "kept"}
        assert found["nested"] == pose
        assert found["png"] == pose
        assert found["cbor"] == pose
        assert found["cborRaw"] == {"isNow": True, "bytes": payload.hex()}
        assert found["scan"] == {"length": 20_003, "head": [None, 1, None], "max": None}
        assert found["scanCbor"] == {"kind": "Float32Array", "length": 20_003, "last": 2.5}
        assert found["image"] == {"length": IMAGE_BYTES, "head": [0, 1, 2, 3], "frame": "camera"}
        assert found["imageCbor"] == {"kind": "Uint8Array", "length": IMAGE_BYTES, "head": [0, 1, 2, 3]}
        assert found["throttled"] is True
        assert found["called"] == {"success": True, "message": "enabled"}
        assert "the motor is missing" in found["refused"]
        assert "/nobody" in found["absent"]
        assert found["parameters"] == {"value": [1.5, 2.5], "isListed": True}
        assert found["nodeDetails"][:2] == ["/fast", "/image"]
        assert found["action"] == "tool to base"
        assert found["served"] is True
        if ros == "zenoh":
            done, canceled = found["ros2Action"]
            assert done == {"feedback": {"sequence": [3]}, "result": {"sequence": [3, 3]}}
            assert canceled["feedback"] == {"sequence": [9]}
            assert "canceled" in canceled["error"].lower()
        assert found["reconnected"] == {"data": "kept"}
        is_ros1 = ros == "ros1"
        assert found["rosapi"] == {
            "poseType": "geometry_msgs/PoseStamped" if is_ros1 else "geometry_msgs/msg/PoseStamped",
            "topicType": "geometry_msgs/PoseStamped" if is_ros1 else "geometry_msgs/msg/PoseStamped",
            "topicsForType": ["/pose"],
            "nodes": ["/gateway", "/rosapi", "/talker"],
            "services": ["/enable", "/fail"],
            "serviceType": "std_srvs/SetBool" if is_ros1 else "std_srvs/srv/SetBool",
            "servicesForType": ["/enable"],
            "request": ["data"],
            "response": ["success", "message"],
            "decoded": {
                "linear": {"x": "float64", "y": "float64", "z": "float64"},
                "angular": {"x": "float64", "y": "float64", "z": "float64"},
            },
            # Actions of ROS 2 are not topics.
            "actionServers": ["/lookup"] if is_ros1 else [],
            "rawTypes": True,
        }

        twist = stage.received["/from_page"][0]
        assert (twist.linear.x, twist.angular.z) == (1.5, -0.5)
        assert stage.received["/text_from_page"][0].data == "grüße \U0001f600"
        assert stage.received["/bytes_from_page"][0].data == b"\x01\x02\xff"
