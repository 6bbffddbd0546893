from __future__ import annotations

import pytest

from rostether.graph.typed_graph import TypedGraph
from rostether.platform.sensing_manager import SensingManager
from rostether.platform.sensors.registered_sensor import platform_word, registered_sensor
from unit.platform.datagrams import running
from unit.platform.sensors.shown_sensors import described, shown_sensors
from unit.platform.typed_nodes import STORE, Lines, typed_nodes
from waiting import until

VALUE = described("ANALOG", "std_msgs/Float64", unit="m", rate_hz=5.0)


async def test_it_publishes_before_there_is_a_manager_and_after_it_has_restarted() -> None:
    network, (node, robot, viewer) = await typed_nodes("/sensing_manager", "/robot", "/viewer")
    lines, values = Lines(), []
    async with registered_sensor(robot, VALUE, lines) as sensor:
        await viewer.subscriber("/sensors/robot3/front", "std_msgs/Float64", lambda m: values.append(m.data))
        await until(lambda: sensor.is_wanted)
        sensor.publish(data=1.0)
        await until(lambda: values == [1.0])
        sensor.set_state("ready")
        # The second manager knows nothing of the first.
        for _ in range(2):
            async with running(SensingManager(node, Lines()).run()):
                message = await viewer.wait_for_message("/sensors", timeout_s=60)
                while [each.state for each in message.sensors] != ["ready"]:
                    message = await viewer.wait_for_message("/sensors", timeout_s=60)
        found = message.sensors[0]
        assert (found.name, found.unit, found.rate_hz, found.lease_s) == ("Front", "m", 5.0, 12.0)
    assert lines.texts[0].startswith("not registered as robot3/front yet: ")
    assert lines.texts[1] == "registered as robot3/front, on topic /sensors/robot3/front"
    assert network.snapshot().topics["/sensors/robot3/front"].publishers == ()


async def test_a_second_node_with_the_same_id_does_not_publish() -> None:
    async with shown_sensors() as shown:
        other = TypedGraph(await shown.network.join("/other"), STORE)
        async with registered_sensor(shown.robot, VALUE, shown.report) as first:
            first.set_state("ready")
            await shown.has_state("robot3/front", "ready")
            lines = Lines()
            async with registered_sensor(other, VALUE, lines) as second:
                await until(lambda: lines.texts)
                assert lines.texts[0].startswith("not publishing: /robot on ")
                assert lines.texts[0].endswith(" is registered as robot3/front; choose another ~id")
                assert not second.is_wanted


@pytest.mark.parametrize(
    ("platform", "word"), [("Robot3", "Robot3"), ("Robot 3", "Robot_3"), ("3", "p3"), ("", "p")]
)
def test_a_platforms_word(platform: str, word: str) -> None:
    assert platform_word(platform) == word
