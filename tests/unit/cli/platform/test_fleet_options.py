from __future__ import annotations

import pytest

from rostether.platform.fleet import FleetSettings
from rostether.platform.robot_table import Robot
from rostether.platform.status_frame import RobotStatus
from unit.cli.command_shell import Shell


@pytest.mark.parametrize("words", [(), ("3", "--all"), ("--groups", "1", "--all")])
def test_drive_needs_one_kind_of_target(shell: Shell, words: tuple[str, ...]) -> None:
    assert "give one of ROBOT, --groups or --all" in shell.failure("fleet", "drive", *words, code=2)


class Sender:
    """A sender that reports one robot that has stopped, and one that still moves."""

    def __init__(self, *_: object) -> None: ...

    async def stop(self) -> list[Robot]:
        moving = RobotStatus(2, 1, 1, is_moving=True)
        return [Robot(RobotStatus(1, 1, 1), ("10.0.0.1", 9), 0.0), Robot(moving, ("10.0.0.2", 9), 0.0)]

    def close(self) -> None: ...


def test_who_confirms_a_stop(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.cli.platform.fleet.FleetSender", Sender)
    stopped = shell("fleet", "stop")
    assert stopped.out == "robot 1 at 10.0.0.1 has stopped\n"
    assert stopped.err == "robot 2 at 10.0.0.2 has NOT confirmed the stop\n"
    as_json = shell("fleet", "stop", "--json")
    assert as_json.records == [
        {"robot": 1, "address": "10.0.0.1", "stopped": True},
        {"robot": 2, "address": "10.0.0.2", "stopped": False},
    ]
    assert (stopped.code, as_json.code) == (1, 1)


def test_the_doctor_of_boards_examines_a_fleet(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    examined: list[tuple[str, ...]] = []

    async def examine(settings: FleetSettings, *_: object, **__: object) -> int:
        examined.append(settings.address.interfaces)
        return 0

    monkeypatch.setattr("rostether.cli.platform.fleet.examine_fleet", examine)
    shell.output("doctor", "--fleet", "--interface", "wlan0", "--interface", "eth0")
    assert examined == [("wlan0", "eth0")]
    assert "--interface need --fleet" in shell.failure("doctor", "--interface", "wlan0", code=2)
