from __future__ import annotations

from collections.abc import Callable
from xmlrpc.client import ServerProxy

import click
import pytest

from rostether.cli.access import completions
from unit.cli.command_shell import STORE, LiveGraph, Shell

Complete = Callable[[click.Context, click.Parameter, str], list[str]]

CONTEXT = click.Context(click.Command("any"))
PARAMETER = click.Argument(["any"])


@pytest.fixture(autouse=True)
def _on_a_busy_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(completions, "ROS1_TIMEOUT_S", 60.0)
    # Nodes that do not answer stay registered until the test has ended.
    monkeypatch.setattr("rostether.ros1.master.node_calls._REFUSALS_UNTIL_GONE", 10**9)


@pytest.fixture
def board(graph: LiveGraph) -> None:
    async def answer(_request: bytes) -> bytes:
        return b""

    node = graph.node("board")
    graph.do(node.advertise("/chatter", STORE.registry.message_type("std_msgs/String")))
    graph.do(node.subscribe("/led", STORE.registry.message_type("std_msgs/Bool"), lambda _: None))
    graph.do(node.advertise_service("/reset", STORE.registry.service_type("std_srvs/Empty"), answer))
    graph.do(node.set_param("/blink_hz", 2.5))


@pytest.mark.parametrize(
    ("complete", "typed", "found"),
    [
        (completions.complete_topics, "", ["/chatter", "/led", "/rosout"]),
        (completions.complete_topics, "/ch", ["/chatter"]),
        (completions.complete_topics, "ch", ["/chatter"]),
        (completions.complete_nodes, "b", ["/board"]),
        (completions.complete_services, "", ["/reset"]),
        (completions.complete_params, "/bl", ["/blink_hz"]),
        (completions.complete_params, "x", []),
        (completions.complete_message_types, "std_msgs/Str", ["std_msgs/String"]),
        (completions.complete_service_types, "std_srvs/S", ["std_srvs/SetBool"]),
    ],
)
@pytest.mark.usefixtures("board")
def test_names_that_begin_with_what_was_typed(complete: Complete, typed: str, found: list[str]) -> None:
    assert complete(CONTEXT, PARAMETER, typed) == found


@pytest.mark.usefixtures("board")
def test_names_that_a_shell_would_execute_are_not_offered(graph: LiveGraph) -> None:
    with ServerProxy(graph.uri) as api:
        for name in ("/z$(reboot)", "/z`reboot`", "/z;reboot", "/z'", "/z*", "/z&", "/zebra~1"):
            assert api.registerPublisher("/odd", name, "std_msgs/Empty", "http://127.0.0.1:1/")[0] == 1  # type: ignore[index]
    assert completions.complete_topics(CONTEXT, PARAMETER, "/z") == ["/zebra~1"]


@pytest.mark.usefixtures("shell")
def test_without_a_master_there_is_nothing_to_complete(capsys: pytest.CaptureFixture[str]) -> None:
    for complete in (completions.complete_topics, completions.complete_nodes, completions.complete_params):
        assert complete(CONTEXT, PARAMETER, "") == []
    assert capsys.readouterr() == ("", "")


def test_a_master_that_hangs_costs_a_moment(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    import socket

    monkeypatch.setattr(completions, "ROS1_TIMEOUT_S", 0.05)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{silent.getsockname()[1]}")
        assert completions.complete_services(CONTEXT, PARAMETER, "") == []


@pytest.mark.usefixtures("board")
def test_fields_follow_their_topic() -> None:
    assert completions.complete_fields(CONTEXT, PARAMETER, "/chatter/d") == ["/chatter/data"]
    assert completions.complete_fields(CONTEXT, PARAMETER, "/ch") == ["/chatter"]
    types = {"/imu": "sensor_msgs/Imu"}
    found = completions.field_names(STORE.registry, types, "/imu/orientation/")
    assert found == [f"/imu/orientation/{axis}" for axis in "xyzw"]
    for typed in ("/imu/nope/", "/imu/orientation/x/", "/other/"):
        assert completions.field_names(STORE.registry, types, typed) == []


@pytest.mark.usefixtures("board")
def test_the_type_of_a_topic_that_is_there_is_completed() -> None:
    context = click.Context(click.Command("any"))
    context.params["topic"] = "/chatter"
    assert completions.complete_topic_type(context, PARAMETER, "") == ["std_msgs/String"]
    context.params["topic"] = "/new"
    assert completions.complete_topic_type(context, PARAMETER, "std_msgs/Str") == ["std_msgs/String"]
