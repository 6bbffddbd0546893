from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from rostether.errors import ServiceCallError
from rostether.graph.typed_graph import TypedGraph
from rostether.platform import sensing_manager
from rostether.platform.digital_tester import publish_test_values
from rostether.platform.sensing_manager import SensingManager
from rostether.platform.sensor_files import read_state
from rostether.platform.sensor_registry import Sensor
from unit.platform.datagrams import running
from unit.platform.typed_nodes import Lines, typed_nodes
from waiting import until

REGISTER = "sensors/RegistrationService"


class Screen:
    """The latest list of sensors, as received by another program."""

    def __init__(self) -> None:
        self.states: dict[str, str] = {}
        self.names: dict[str, str] = {}
        self.text = ""

    async def listen(self, node: TypedGraph) -> None:
        async for message in node.messages("/sensors", "sensing_platform/Sensors"):
            self.states = {each.id: each.state for each in message.sensors}
            self.names = {each.id: each.name for each in message.sensors}
            self.text = "".join(each.state_text for each in message.sensors)


async def register(node: TypedGraph, sensor_type: str) -> str:
    answer = await node.call(
        "/sensors_register", REGISTER, {"platform_name": "Robot", "sensor_type": sensor_type}
    )
    return str(answer.topic)


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sensing_manager, "STATE_PERIOD_S", 0.01)
    monkeypatch.setattr(sensing_manager, "GATHER_S", 0.001)


async def test_a_sensors_life(tmp_path: Path) -> None:
    network, (node, robot, viewer) = await typed_nodes("/sensing_manager", "/robot", "/viewer")
    screen, state_path = Screen(), tmp_path / "sensors.json"
    manager = SensingManager(node, Lines(), state_path=state_path)
    async with running(screen.listen(viewer), manager.run()):
        await until(lambda: "/sensors_rename" in network.snapshot().services)
        assert await register(robot, "ANALOG") == "sensor_node0"
        assert await register(robot, "CAMERA") == "sensor_node1"
        await until(lambda: screen.states == {"sensor_node0": "init", "sensor_node1": "init"})
        value = await robot.publisher("sensor_node0", "std_msgs/Float64")
        camera = await robot.publisher("sensor_node1", "sensor_msgs/CompressedImage")
        await until(lambda: value.subscriber_count)
        value.publish(data=1.0)
        await until(lambda: screen.states == {"sensor_node0": "ready", "sensor_node1": "ready"})
        assert camera.subscriber_count == 0
        rename = {"id": "sensor_node0", "name": "Front distance"}
        answer = await robot.call("/sensors_rename", "sensing_platform/RenameSensor", rename)
        assert (answer.sensor.id, answer.sensor.name) == ("sensor_node0", "Front distance")
        assert answer.sensor.state_since.secs > 0
        await value.close()
        await until(lambda: screen.states["sensor_node0"] == "disconnected")
        assert await register(robot, "ANALOG") == "sensor_node0"
        with pytest.raises(
            ServiceCallError, match="sensor_type must be one of CAMERA, ANALOG, DIGITAL, not 'RADAR'"
        ):
            await register(robot, "RADAR")
    screen.states.clear()
    # The manager starts again: all sensors are back, with their names, and numbers go on.
    again = SensingManager(node, Lines(), state_path=state_path)
    async with running(screen.listen(viewer), again.run()):
        await until(lambda: screen.states == {"sensor_node0": "disconnected", "sensor_node1": "ready"})
        assert screen.names["sensor_node0"] == "Front distance"
        assert await register(robot, "DIGITAL") == "sensor_node2"


BY_ID = {
    "id": "robot3/front",
    "instance": "/camera",
    "name": "Front",
    "platform_name": "Robot 3",
    "sensor_type": "CAMERA",
    "message_type": "sensor_msgs/CompressedImage",
    "lease_s": 12.0,
}


async def test_a_sensor_with_an_id_and_a_manager_that_forgot_all() -> None:
    network, (node, robot, viewer) = await typed_nodes("/sensing_manager", "/robot", "/viewer")
    screen = Screen()

    async def register_by_id(**change: object) -> str:
        answer = await robot.call(
            "/sensors_register_by_id", "sensing_platform/RegisterSensor", BY_ID | change
        )
        return str(answer.topic)

    for run in range(2):
        async with running(screen.listen(viewer), SensingManager(node, Lines()).run()):
            await until(lambda: "/sensors_rename" in network.snapshot().services)
            if run == 0:
                assert await register(robot, "ANALOG") == "sensor_node0"
                await robot.publisher("/sensor_node0", "std_msgs/Float64")
            assert await register_by_id() == "/sensors/robot3/front"
            await robot.publisher("/sensors/robot3/front", "sensor_msgs/CompressedImage")
            await until(lambda: screen.states.get("robot3/front") == "ready")
            # The second manager finds the topic in use.
            await until(lambda: screen.states.get("sensor_node0") == "init")
            await register_by_id(state="alert", state_text="no camera")
            await until(lambda: screen.states["robot3/front"] == "alert")
            assert screen.text == "no camera"
        screen.states.clear()


async def test_a_sensor_of_an_earlier_manager_is_saved(tmp_path: Path) -> None:
    _, (node, robot) = await typed_nodes("/sensing_manager", "/robot")
    await robot.publisher("/sensor_node4", "std_msgs/Float64")
    state_path = tmp_path / "sensors.json"
    async with running(SensingManager(node, Lines(), state_path=state_path).run()):
        await until(lambda: [each.id for each in read_state(state_path)] == ["sensor_node4"])


async def test_a_boards_topic_is_a_named_sensor() -> None:
    _, (node, board, viewer) = await typed_nodes("/sensing_manager", "/board", "/viewer")
    screen = Screen()
    named = Sensor("arm/ultrasound", -1, "arm", "ANALOG", "/arm/ultrasound", "Distance", unit="m")
    async with running(screen.listen(viewer), SensingManager(node, Lines(), named=[named]).run()):
        await until(lambda: screen.names == {"arm/ultrasound": "Distance"})
        # Any type: the manager does not read the value.
        topic = await board.publisher("/arm/ultrasound", "sensor_msgs/Range")
        await until(lambda: topic.subscriber_count)
        topic.publish(range=0.5)
        await until(lambda: screen.states["arm/ultrasound"] == "ready")


async def test_a_folder_that_cannot_be_written_is_reported_once(tmp_path: Path) -> None:
    network, (node, robot) = await typed_nodes("/sensing_manager", "/robot")
    (tmp_path / "file").touch()
    lines = Lines()
    async with running(SensingManager(node, lines, state_path=tmp_path / "file" / "s.json").run()):
        await until(lambda: "/sensors_register" in network.snapshot().services)
        assert await register(robot, "ANALOG") == "sensor_node0"
        await until(lambda: "cannot write" in "".join(lines.texts))
        assert await register(robot, "ANALOG") == "sensor_node1"
    assert sum("cannot write" in each for each in lines.texts) == 1


async def test_the_digital_tester_waits_for_the_manager(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.platform.digital_tester._RETRY_S", 0.01)
    monkeypatch.setattr("rostether.platform.digital_tester.PERIOD_S", 0.01)
    _, (tester, node, viewer) = await typed_nodes("/digital_tester", "/sensing_manager", "/viewer")
    lines = Lines()
    async with running(publish_test_values(tester, "Robot", lines)):
        await until(lambda: lines.texts)
        async with running(SensingManager(node, Lines()).run()):
            values = []
            async with asyncio.timeout(60):
                async for message in viewer.messages("/sensor_node0", "std_msgs/Float64"):
                    values.append(message.data)
                    if len(values) == 3:
                        break
    assert all(each in range(101) for each in values)
    assert lines.texts == [
        "no sensing manager answers; start one: rostether role sensing-manager",
        "registered for topic sensor_node0",
    ]
