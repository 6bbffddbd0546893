from __future__ import annotations

import signal

from programs import TIMEOUT_S, in_terminal, running
from unit.cli.command_shell import LiveGraph, Shell
from unit.robot.robots import ARM

SLIDERS = ("role", "joint-state-publisher-gui")


def test_keys_move_joints_and_q_ends(graph: LiveGraph, shell: Shell) -> None:
    graph.do(graph.node("setter").set_param("/robot_description", ARM))
    with in_terminal(*SLIDERS, ROS_MASTER_URI=graph.uri) as terminal:
        terminal.wait_for("> j0")
        terminal.type(b"\033[B\033[5~")
        terminal.wait_for("> j1")
        terminal.wait_for("0.4000")
        # The joints are shown before the topic is registered; then echo prints that it waits.
        received = shell("topic", "echo", "-n", "1", "/joint_states/position")
        assert received.out.startswith("[0.0, 0.4, 0.0]"), received
        terminal.type(b"q")
        terminal.wait_for("\033[?1049l")
        assert terminal.process.wait(TIMEOUT_S) == 0


def test_ctrl_c_restores_the_terminal(graph: LiveGraph) -> None:
    graph.do(graph.node("setter").set_param("/robot_description", ARM))
    with in_terminal(*SLIDERS, ROS_MASTER_URI=graph.uri) as terminal:
        terminal.wait_for("> j0")
        terminal.process.send_signal(signal.SIGINT)
        terminal.wait_for("\033[?1049l")
        terminal.process.wait(TIMEOUT_S)


def test_without_a_terminal_it_publishes_zeros(graph: LiveGraph, shell: Shell) -> None:
    graph.do(graph.node("setter").set_param("/robot_description", ARM))
    with running(*SLIDERS, "_rate:=50", ROS_MASTER_URI=graph.uri) as process:
        shell("topic", "echo", "-n", "1", "/joint_states")
        process.terminate()
        _, reported = process.communicate(timeout=TIMEOUT_S)
    assert "no terminal for the sliders" in reported
