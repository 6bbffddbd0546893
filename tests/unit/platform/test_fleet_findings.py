from __future__ import annotations

from msgspec.structs import replace

from rostether.platform.fleet_examination import Examination
from rostether.platform.fleet_findings import FleetFinding, disk_finding, fleet_findings
from rostether.platform.fleet_survey import ClockOffset
from rostether.platform.robot_table import Robot, RobotKey
from rostether.platform.status_frame import HostState, RobotStatus

SILENCE = "no robot answers"


def robots(*found: tuple[int, float | None, int | None]) -> dict[RobotKey, Robot]:
    """Return robots by id, loss and signal."""
    return {
        RobotKey(number, f"10.0.0.{number}"): Robot(
            RobotStatus(number, 1, 1, signal_dbm=signal_dbm, host=HostState(0, 10**9)),
            (f"10.0.0.{number}", 5),
            0.0,
            loss,
        )
        for number, loss, signal_dbm in found
    }


def problems(found: Examination) -> list[FleetFinding]:
    return [each for each in fleet_findings(found, SILENCE) if each.is_ok is False]


def test_each_robot_has_a_finding() -> None:
    fleet = robots((1, None, None), (2, 0.05, -60), (3, 0.3, -80))
    findings = fleet_findings(Examination(True, fleet, robots((3, 0.02, None))), SILENCE)
    assert [(each.is_ok, each.what) for each in findings] == [
        (True, "robot 1"),
        (True, "robot 2"),
        (False, "robot 3"),
    ]
    assert findings[2].text.startswith("30% of multicast, and 2% of unicast, are lost")
    assert "-80 dBm is weak" in findings[2].text


def test_a_fleet_that_does_not_answer_and_a_full_disk() -> None:
    (silent,) = fleet_findings(Examination(True), SILENCE)
    assert (silent.is_ok, silent.text) == (False, SILENCE)
    assert disk_finding("here", 5_000_000_000, 9_000_000_000).is_ok
    assert not disk_finding("here", 1_000_000, 9_000_000_000).is_ok


def test_clocks_are_compared_beyond_the_error_of_their_measurement() -> None:
    ahead, behind = ClockOffset(0.06, 0.001), ClockOffset(-0.06, 0.001)
    found = Examination(
        True, robots((1, 0.0, None)), clocks={RobotKey(1, "a"): ahead, RobotKey(2, "b"): behind}
    )
    (finding,) = problems(found)
    assert finding.text.startswith("the clock of robot 1 (a) is 0.1 s ahead of that of robot 2 (b)")
    found.clocks[RobotKey(1, "a")] = replace(ahead, error_s=0.05)
    assert not problems(found)


def test_a_querier_is_missing_only_after_the_longest_interval() -> None:
    found = Examination(True, robots((1, 0.0, None)), has_querier=False, listened_s=129.0)
    assert not problems(found)
    found.listened_s = 130.0
    assert [each.what for each in problems(found)] == ["IGMP querier"]
    found.has_querier = None
    assert "needs root (sudo)" in fleet_findings(found, SILENCE)[-1].text


def test_many_pairs_of_robots_are_not_all_listed() -> None:
    pairs = [(RobotKey(number, "a"), RobotKey(number + 1, "b"), False) for number in range(1, 9)]
    (finding,) = problems(Examination(True, robots((1, 0.0, None)), pairs=pairs))
    assert "robot 5 does not reach robot 6 and 3 more; turn off client isolation" in finding.text
