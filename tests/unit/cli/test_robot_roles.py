from __future__ import annotations

from programs import running
from unit.cli.command_shell import LiveGraph, Shell
from unit.robot.robots import ARM


def test_roles_publish_joints_and_transforms(graph: LiveGraph, shell: Shell) -> None:
    graph.do(graph.node("setter").set_param("/robot_description", ARM))
    states = ("role", "joint-state-publisher", "__name:=joints", "_rate:=50", "joint_states:=arm/joints")
    frames = ("role", "robot-state-publisher", "joint_states:=arm/joints", "_publish_frequency:=20")
    with (
        running(*states, ROS_MASTER_URI=graph.uri) as joints,
        running(*frames, ROS_MASTER_URI=graph.uri) as state,
    ):
        assert "- Translation: [" in shell("tf", "echo", "-n", "1", "base", "hand").out
        assert shell.output("param", "get", "/joints/rate") == "50\n"
        assert shell.output("node", "list").split() == ["/joints", "/robot_state_publisher", "/setter"]
        shell("node", "kill", "/joints")
        assert joints.wait(60) == 0
        state.terminate()
        assert state.wait(60) == 0


def test_without_a_description_a_line_names_the_parameter(graph: LiveGraph) -> None:
    for role in ("robot-state-publisher", "joint-state-publisher"):
        with running("role", role, ROS_MASTER_URI=graph.uri) as process:
            _, reported = process.communicate(timeout=60)
            assert process.returncode == 1
            assert "the parameter robot_description has no URDF; set it in a launch file" in reported
