from __future__ import annotations

import asyncio
import signal
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import pytest

from interop.ros1_peers import free_port
from programs import read_until, running
from rostether.cli.demo.demo import Controls
from rostether.graph.ports import Publisher
from rostether.simulation.ultrasound import Obstacle
from unit.cli.command_shell import LiveGraph, Shell

pytestmark = pytest.mark.slow

PYTHON_DEMO = ("demo", "--board", "python")


def test_the_demo_is_interrupted(graph: LiveGraph) -> None:
    with running(*PYTHON_DEMO, "--join", ROS_MASTER_URI=graph.uri) as process:
        read_until(process, "virtual board ready")
        process.send_signal(signal.SIGINT)
        text, reported = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "connect again" not in f"{text}{reported}"
    assert not graph.master.api.registrations.nodes


def test_the_demo_keeps_out_of_a_graph_that_runs(graph: LiveGraph) -> None:
    with running(*PYTHON_DEMO, "--ros1", "--seconds", "20", ROS_MASTER_URI=graph.uri) as process:
        lines = read_until(process, "virtual board ready")
        assert not graph.master.api.registrations.nodes
    own = next(line for line in lines if "Started a ROS master" in line)
    assert graph.uri.rstrip("/") not in own


def test_settings_are_tried_on_the_demo_s_board(graph: LiveGraph, tmp_path: Path) -> None:
    config = tmp_path / "devices.toml"
    config.write_text(
        '[devices.virtual_board]\naddress = "127.0.0.1"\n'
        'required_topics = ["odom"]\naccess = { publish = { deny = ["/tf"] } }\n'
    )
    with running(
        *PYTHON_DEMO,
        "--join",
        "--config",
        str(config),
        ROS_MASTER_URI=graph.uri,
    ) as process:
        assert process.stderr is not None
        missing = {"may not publish /tf", "does not announce odom, which devices.toml requires"}
        for line in process.stderr:
            missing -= {each for each in missing if each in line}
            if not missing:
                break
    assert not missing


def test_the_user_s_own_settings_do_not_spoil_the_demo(
    graph: LiveGraph, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = tmp_path / "rostether" / "devices.toml"
    config.parent.mkdir()
    config.write_text("[defaults]\naccess = { publish = { allow = [] } }\n")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    with running(*PYTHON_DEMO, "--join", ROS_MASTER_URI=graph.uri) as process:
        # A line that is printed once a message was received.
        assert "ultrasound" in read_until(process, " Hz (")[-1]


def test_demos_side_by_side_have_separate_masters(shell: Shell) -> None:
    port = free_port()
    with (
        running(*PYTHON_DEMO, "--ros1", "--no-page", ROS_MASTER_URI=f"http://localhost:{port}") as first,
        running(*PYTHON_DEMO, "--ros1", "--no-page", ROS_MASTER_URI=f"http://localhost:{port}") as second,
    ):
        masters = {
            line.partition("ROS_MASTER_URI=")[2]
            for process in (first, second)
            for line in read_until(process, "virtual board ready")
            if "ROS_MASTER_URI" in line
        }
        assert len(masters) == 2
        assert f"uses port {port} already" in shell.failure(*PYTHON_DEMO, "--port", str(port))
        assert "omit --port" in shell("demo", "--join", "--port", "1").err


class Switch:
    """The LED's publisher, and what it published."""

    subscriber_count = 0

    def __init__(self) -> None:
        self.sent: list[bytes] = []

    def publish_raw(self, payloads: Sequence[bytes]) -> bool:
        self.sent += payloads
        return True


async def test_presses_wait_until_the_board_subscribes() -> None:
    controls = Controls(Obstacle(), lambda: 0.0)
    switch = Switch()
    advertised: list[Switch] = []

    async def advertise() -> Publisher:
        advertised.append(switch)
        return cast("Publisher", switch)

    controls.advertise = advertise
    controls.send_toggles()
    await asyncio.sleep(0)
    # The dashboard has a button only for a topic that no other node publishes.
    assert advertised == []
    controls.press(b"ll\033[A")
    await asyncio.sleep(0)
    controls.send_toggles()
    assert (advertised, switch.sent) == ([switch], [])
    switch.subscriber_count = 1
    controls.send_toggles()
    controls.send_toggles()
    assert switch.sent == [b"", b""]
