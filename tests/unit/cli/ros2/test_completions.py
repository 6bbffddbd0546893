from __future__ import annotations

from collections.abc import Callable

import click
import pytest

from rostether.cli.access import completions
from unit.cli.command_shell import Shell
from unit.cli.ros2.zenoh_world import ZenohWorld

Complete = Callable[[click.Context, click.Parameter, str], list[str]]


@pytest.fixture(autouse=True)
def _on_a_busy_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(completions, "ROS2_TIMEOUT_S", 60.0)


@pytest.mark.parametrize(
    ("complete", "typed", "found"),
    [
        (completions.complete_topics, "/im", ["/imu"]),
        (completions.complete_nodes, "far", ["/far/board"]),
        (completions.complete_services, "/set", ["/set_led"]),
        (completions.complete_params, "/far/b", ["/far/board"]),
        (completions.complete_message_types, "std_msgs/msg/Str", ["std_msgs/msg/String"]),
        (completions.complete_service_types, "std_srvs/srv/S", ["std_srvs/srv/SetBool"]),
    ],
)
def test_names_of_ros2(
    world: ZenohWorld, shell: Shell, complete: Complete, typed: str, found: list[str]
) -> None:
    assert complete(click.Context(click.Command("any")), click.Argument(["any"]), typed) == found


def test_the_option_selects_ros2_as_the_variable_does(
    world: ZenohWorld, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("RMW_IMPLEMENTATION")
    monkeypatch.setenv("_ROSTETHER_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "rostether topic echo --ros2 zenoh /im")
    monkeypatch.setenv("COMP_CWORD", "5")
    assert shell.output() == "plain,/imu\n"
