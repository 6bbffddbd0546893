"""Which ROS graph a command line selects."""

from __future__ import annotations

import subprocess
import sys

import click
import pytest

from rostether.cli.access.graph_options import (
    ANY_MIDDLEWARE,
    GraphOptions,
    Middleware,
    chosen_middleware,
    graph_options,
    is_middleware,
)
from rostether.cli.main import main, rostether
from rostether.cli.shell.option_group import insert_value
from rostether.cli.shell.verbs import Verb


@pytest.mark.parametrize(
    ("typed", "read"),
    [
        (["--ros2", "zenoh", "/chat"], ["--ros2", "zenoh", "/chat"]),
        (["--ros2", "/chat"], ["--ros2=any", "/chat"]),
        (["/chat", "--ros2"], ["/chat", "--ros2=any"]),
        (["--ros2", "dds", "/chat"], ["--ros2", "dds", "/chat"]),
        (["--ros2=rclpy", "-v"], ["--ros2=rclpy", "-v"]),
        (["--ros2", "--", "zenoh"], ["--ros2=any", "--", "zenoh"]),
        (["--", "--ros2", "x"], ["--", "--ros2", "x"]),
        ([], []),
    ],
)
def test_the_word_behind_ros2_counts_only_as_a_middleware(typed: list[str], read: list[str]) -> None:
    assert insert_value(typed, "--ros2", ANY_MIDDLEWARE, is_middleware) == read


@pytest.mark.parametrize("name", ["dds", "CycloneDDS", "rmw_fastrtps_cpp"])
def test_another_middleware_is_neither_an_address_nor_a_topic(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for words in (("serve", "/dev/ttyACM0", "--ros2", name), ("topic", "echo", "--ros2", name)):
        assert main(words) == 2
        line = capsys.readouterr().err.splitlines()[-1]
        assert f"'--ros2': '{name}' is not zenoh or rclpy; use rclpy for other middlewares" in line


def test_zenoh_by_the_name_that_ros_has_for_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(("topic", "list", "--ros2", "rmw_zenoh_cpp")) == 2
    assert "write --ros2 zenoh instead of 'rmw_zenoh_cpp'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "environ", "ros1", "ros2"),
    [
        ([], {}, True, None),
        ([], {"ROS_VERSION": "1", "RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}, True, None),
        ([], {"RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}, False, Middleware.ZENOH),
        ([], {"ROS_VERSION": "2", "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}, False, Middleware.RCLPY),
        (["--ros1"], {"ROS_VERSION": "2"}, True, None),
        (["--ros2", "zenoh"], {"ROS_VERSION": "1"}, False, Middleware.ZENOH),
        (["--ros2"], {"RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}, False, Middleware.ZENOH),
        (["--ros1", "--ros2=rclpy"], {}, True, Middleware.RCLPY),
    ],
)
def test_what_is_typed_goes_before_the_environment(
    arguments: list[str],
    environ: dict[str, str],
    ros1: bool,
    ros2: Middleware | None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ("ROS_VERSION", "RMW_IMPLEMENTATION"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    seen: list[tuple[bool, Middleware | None]] = []

    @click.command(cls=Verb)
    @graph_options(zenoh=True)
    def command(graph: GraphOptions) -> None:
        seen.append((graph.uses_ros1, graph.ros2))

    command.main(arguments, standalone_mode=False)
    assert seen == [(ros1, ros2)]


def test_a_tool_of_one_graph_refuses_two() -> None:
    with pytest.raises(click.UsageError, match="give --ros1 or --ros2, not both"):
        rostether.main(["topic", "list", "--ros1", "--ros2", "zenoh"], standalone_mode=False)


def test_ros2_without_a_middleware_uses_the_installed_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_VERSION", "2")
    monkeypatch.delenv("RMW_IMPLEMENTATION", raising=False)
    monkeypatch.setattr("rostether.cli.access.graph_options.find_spec", lambda name: None)
    assert chosen_middleware() is Middleware.ZENOH
    monkeypatch.setattr("rostether.cli.access.graph_options.find_spec", lambda name: object())
    assert chosen_middleware() is Middleware.RCLPY


@pytest.mark.parametrize(
    "words",
    [
        ("core", "--zenoh-listen", "tcp/0.0.0.0:7447"),
        ("serve", "--zenoh-router", "never", "pty:/tmp/x"),
        ("serve", "--ros2", "rclpy", "--zenoh-connect", "tcp/robot1:7447", "pty:/tmp/x"),
        ("serve", "--params-file", __file__, "pty:/tmp/x"),
        ("bag", "record", "-a", "--zenoh-connect", "tcp/robot1:7447"),
    ],
)
def test_options_of_a_graph_that_is_not_selected_are_refused(
    words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("ROS_VERSION", "RMW_IMPLEMENTATION"):
        monkeypatch.delenv(name, raising=False)
    assert main(words) == 1
    option = next(each for each in words if each.startswith(("--zenoh", "--params")))
    assert f"{option} has an effect only with --ros2" in capsys.readouterr().err


@pytest.mark.usefixtures("cold_start")
def test_the_help_of_a_tool_needs_no_msgspec() -> None:
    # It would start 10 ms later.
    program = "import sys, rostether.cli.access.graph_options; assert 'msgspec' not in sys.modules"
    subprocess.run([sys.executable, "-c", program], check=True)
