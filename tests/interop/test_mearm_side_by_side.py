"""The MeArm's nodes send the same bytes with Debian's rospy and with rostether's."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from interop.mearm_workspace import EXAMPLE, PACKAGE, show_packages
from interop.ros1_peers import Ros1Peers
from programs import start_command
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.param_yaml import parse_single_document
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.node import join_ros1
from rostether.serde.store import TypeStore
from waiting import until

STORE = TypeStore(Registry([EXAMPLE]))
SEQ_AND_STAMP_BYTES = 12
TOPICS = {"/joint_states": "sensor_msgs/JointState", "/servo_pose_server": "mearm_model/ServoAngles"}
# Definitions differ in their comments, which rostether omits; the same md5sum shows that the rest is equal.
HEADER_FIELDS = ("md5sum", "type", "latching")


class Recorder:
    """Records the messages of two topics, without counts and times, and without repetitions."""

    def __init__(self) -> None:
        self.payloads: dict[str, list[bytes]] = {topic: [] for topic in TOPICS}
        self.headers: dict[str, dict[str, str]] = {}

    async def listen(self, graph: TypedGraph) -> None:
        for topic, type_name in TOPICS.items():
            await graph.raw.subscribe(
                topic,
                STORE.registry.message_type(type_name),
                lambda payloads, topic=topic: self._store(topic, payloads),  # type: ignore[misc]
                on_connection=lambda header, topic=topic: self._store_header(topic, header),  # type: ignore[misc]
            )

    def _store(self, topic: str, payloads: Sequence[bytes]) -> None:
        for payload in payloads:
            body = payload[SEQ_AND_STAMP_BYTES:] if topic == "/joint_states" else payload
            if body not in self.payloads[topic][-1:]:
                self.payloads[topic].append(body)

    def _store_header(self, topic: str, header: Mapping[str, str]) -> None:
        self.headers[topic] = {key: header.get(key, "") for key in HEADER_FIELDS}

    async def wait_for_servos(self, *angles: int) -> None:
        """Wait until these are the last servo angles."""
        expected = struct.pack("<4h", *angles)
        await until(lambda: self.payloads["/servo_pose_server"][-1:] == [expected], f"servos at {angles}")

    async def wait_for_joint_states(self, count: int) -> None:
        """Wait until `count` different joint states have arrived."""
        await until(lambda: len(self.payloads["/joint_states"]) >= count, f"{count} joint states")


async def run_nodes(peers: Ros1Peers, side: str) -> list[Any]:
    """Start both nodes; return what ends them."""
    nodes = []
    for program in ("move.py", "filter.py"):
        if side == "debian":
            nodes.append(await peers.start("rosrun", "mearm_model", program))
        else:
            environment = {"ROS_MASTER_URI": peers.master_uri, "ROS_PACKAGE_PATH": str(EXAMPLE)}
            nodes.append(await start_command("run", "mearm_model", program, environment=environment))
    return nodes


async def run_session(peers: Ros1Peers, side: str) -> tuple[list[bool], Recorder]:
    environment = RosEnvironment.read({}).with_master(peers.master_uri)
    graph = TypedGraph(await join_ros1("/recorder", environment=environment), STORE)
    recorder, answers = Recorder(), []
    nodes = []
    try:
        for name in ("joint_positions_sets", "servo_poses"):
            values = parse_single_document((PACKAGE / "config" / f"{name}.yaml").read_text(), name)
            for key, value in values.items():
                await graph.set_param(f"/{key}", value)
        await recorder.listen(graph)
        nodes = await run_nodes(peers, side)
        async with asyncio.timeout(60):
            while not {"/select_position_set", "/set_servo_pose"} <= set((await graph.snapshot()).services):
                await asyncio.sleep(0.05)
        await recorder.wait_for_servos(0, 0, 0, 0)
        await recorder.wait_for_joint_states(1)

        async def ask(service: str, type_name: str, **request: Any) -> None:
            answer: Any = await graph.call(service, f"mearm_model/{type_name}", request, timeout_s=60)
            answers.append(answer.success)

        await ask("/select_position_set", "MoveJoints", set_name="set3")
        await recorder.wait_for_servos(-14, 0, 14, 29)
        await recorder.wait_for_joint_states(2)
        for refused in ("set2", "", "nothing/of/that", "\udcff"):
            await ask("/select_position_set", "MoveJoints", set_name=refused)
        await ask("/set_servo_pose", "MoveArm", position_id=2)
        await recorder.wait_for_servos(135, 70, 110, 60)
        await ask("/set_servo_pose", "MoveArm", position_id=-1)
        await ask("/select_position_set", "MoveJoints", set_name="set1")
        await recorder.wait_for_servos(0, 29, -29, 14)
        await recorder.wait_for_joint_states(3)
    finally:
        for node in nodes:
            await node.stop()
        await graph.close()
    return answers, recorder


async def test_both_send_the_same_messages(roscore: Ros1Peers, tmp_path: Path) -> None:
    show_packages(roscore, tmp_path / "catkin_ws")
    debian_answers, debian = await run_session(roscore, "debian")
    rostether_answers, rostether = await run_session(roscore, "rostether")
    assert debian_answers == rostether_answers == [True, False, False, False, False, True, False, True]
    assert rostether.payloads == debian.payloads
    assert len(debian.payloads["/servo_pose_server"]) >= 13
    assert rostether.headers == debian.headers
    assert set(rostether.headers) == set(TOPICS)
