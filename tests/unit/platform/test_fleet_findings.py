from __future__ import annotations

from rostether.platform.fleet_findings import disk_finding, fleet_findings
from rostether.platform.robot_table import Robot
from rostether.platform.status_frame import RobotStatus


def robot(number: int, loss: float | None, signal_dbm: int | None = None) -> Robot:
    return Robot(RobotStatus(number, 1, 1, signal_dbm=signal_dbm), (f"10.0.0.{number}", 5), 0.0, loss)


def test_each_robot_has_a_finding() -> None:
    robots = [robot(1, None), robot(2, 0.05, -60), robot(3, 0.3, -80)]
    findings = fleet_findings(robots, {2: ["10.0.0.2", "10.0.0.9"]}, "no robot answers")
    assert [(each.is_well, each.what) for each in findings] == [
        (True, "robot 1"),
        (True, "robot 2"),
        (False, "robot 3"),
        (False, "ids"),
    ]
    assert "30% of the datagrams are lost" in findings[2].text
    assert "-80 dBm is weak" in findings[2].text
    assert "2 robots have the id 2: 10.0.0.2, 10.0.0.9" in findings[3].text


def test_a_fleet_that_does_not_answer_and_a_full_disk() -> None:
    (silent,) = fleet_findings([], {}, "no robot answers")
    assert (silent.is_well, silent.text) == (False, "no robot answers")
    assert disk_finding("here", 5_000_000_000, 9_000_000_000).is_well
    assert not disk_finding("here", 1_000_000, 9_000_000_000).is_well
