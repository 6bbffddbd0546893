from __future__ import annotations

import re
from collections.abc import Sequence

import pytest

from rostether.cli.shell.own_command import CALLED_AS_VARIABLE
from rostether.mechanisms.block_end import closed_at_end
from rostether.msgdef.interface import ServiceType
from rostether.ros1.node.master_client import MasterClient
from unit.cli.command_shell import STORE, LiveGraph, Shell

TEXT = STORE.registry.message_type("std_msgs/String")
SET_BOOL: ServiceType = STORE.registry.service_type("std_srvs/SetBool")


async def refuse(_request: bytes) -> bytes:
    raise AssertionError("this service is not called")


def ignore(_payloads: Sequence[bytes]) -> None:
    pass


@pytest.fixture(autouse=True)
def _on_a_busy_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.cli.node.ros1_ping.node_queries.NODE_TIMEOUT_S", 60.0)


@pytest.fixture
def talker(graph: LiveGraph) -> str:
    """Publish, subscribe to a topic without publishers, and offer a service; returns the node's URI."""
    node = graph.node("talker")
    graph.do(node.advertise("/chatter", TEXT))
    graph.do(node.subscribe("/led", TEXT, ignore))
    graph.do(node.advertise_service("/enable", SET_BOOL, refuse))
    return node.node_uri


@pytest.fixture
def gone(graph: LiveGraph, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of a node that ended without unregistering."""
    # The master's check of its nodes would remove it during a test.
    monkeypatch.setattr("rostether.ros1.master.node_calls._REFUSALS_UNTIL_GONE", 10**9)

    async def register() -> None:
        master = MasterClient(graph.uri, "/gone")
        await master.register_publisher("/chatter", TEXT.name, "http://127.0.0.1:9/")
        await master.register_subscriber("/led", TEXT.name, "http://127.0.0.1:9/")
        await master.register_service("/reset", "rosrpc://127.0.0.1:9", "http://127.0.0.1:9/")
        await master.close()

    graph.do(register())
    return "/gone"


def test_list_names_addresses_and_namespaces(graph: LiveGraph, talker: str, shell: Shell) -> None:
    graph.node("robot1/arm")
    assert shell.output("node", "list") == "/robot1/arm\n/talker\n"
    assert shell.output("node", "list", "robot1") == "/robot1/arm\n"
    assert shell.output("node", "list", "/robot") == ""
    assert shell.output("node", "list", "-u", "talker") == f"{talker}\n"
    assert shell.output("node", "list", "-a", "talker") == f"{talker} \t/talker\n"
    assert shell("node", "list", "--json", "talker").records == [{"node": "/talker", "uri": talker}]


def test_info_prints_what_rosnode_prints(talker: str, shell: Shell) -> None:
    printed = shell.output("node", "info", "talker")
    assert re.sub(r"Pid: \d+", "Pid: 1", printed) == (
        f"{'-' * 80}\n"
        "Node [/talker]\n"
        "Publications: \n * /chatter [std_msgs/String]\n * /rosout [rosgraph_msgs/Log]\n\n"
        "Subscriptions: \n * /led [std_msgs/String]\n\n"
        "Services: \n * /enable\n\n"
        f"\ncontacting node {talker} ...\nPid: 1\n\n"
    )


def test_info_shows_none_and_names_connected_peers(graph: LiveGraph, talker: str, shell: Shell) -> None:
    listener = graph.node("listener")
    graph.do(graph.node("source").advertise("/chatter", TEXT))
    subscriber = graph.do(listener.subscribe("/chatter", TEXT, ignore))
    graph.wait_until(lambda: subscriber.publisher_count == 2)
    printed = shell.output("node", "info", "listener")
    assert "Services: None\n" in printed
    assert re.search(
        rf" \* topic: /chatter\n    \* to: /talker \({re.escape(talker)}\)\n"
        r"    \* direction: inbound \(\d+ - 127.0.0.1:\d+\) \[\d+\]\n    \* transport: TCPROS\n",
        printed,
    )
    record = shell("node", "info", "--json", "listener").records[0]
    assert {each["peer"] for each in record["connections"]} == {"/talker", "/source"}
    assert all(each["direction"] == "inbound" and each["local_port"] for each in record["connections"])


def test_info_quiet_does_not_ask_the_node(gone: str, shell: Shell) -> None:
    assert "contacting" not in shell.output("node", "info", "-q", gone)
    record = shell("node", "info", "-q", "--json", gone).records[0]
    assert (record["pid"], record["services"]) == (None, ["/reset"])
    assert record["publications"] == [{"topic": "/chatter", "type": "std_msgs/String"}]


def test_info_of_an_ended_or_unknown_node(gone: str, talker: str, shell: Shell) -> None:
    assert "cannot be reached" in shell.failure("node", "info", gone)
    assert shell.failure("node", "info", "tallker") == ("no node is called /tallker; did you mean /talker?")


def test_info_of_an_unknown_node_goes_on_with_the_next(
    talker: str, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = shell("node", "info", "-q", "tallker", "talker")
    assert (found.code, "Node [/talker]" in found.out) == (1, True)
    monkeypatch.setenv(CALLED_AS_VARIABLE, "rosnode")
    assert shell("node", "info", "-q", "tallker", "talker").code == 0


def test_ping_once(talker: str, shell: Shell) -> None:
    printed = shell.output("node", "ping", "-c", "1", "talker")
    assert re.fullmatch(
        r"rosnode: node is \[/talker\]\npinging /talker with a timeout of 3.0s\n"
        rf"xmlrpc reply from {re.escape(talker)}\ttime=\d+\.\d{{6}}ms\n",
        printed,
    )


def test_ping_average(talker: str, shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.cli.node.ros1_ping.INTERVAL_S", 0.0)
    lines = shell.output("node", "ping", "-c", "3", "talker").splitlines()
    assert len(lines) == 6
    assert re.fullmatch(r"ping average: \d+\.\d{6}ms", lines[-1])
    records = shell("node", "ping", "-c", "2", "talker", "--json").records
    assert [record["node"] for record in records] == ["/talker", "/talker"]
    assert all(record["reply_ms"] > 0 for record in records)


def test_ping_all_lists_dead_nodes(gone: str, talker: str, shell: Shell) -> None:
    result = shell("node", "ping", "--all")
    assert result.code == 1
    assert result.out.startswith("Will ping the following nodes: \n * /gone\n * /talker\n\n")
    assert f"xmlrpc reply from {talker}" in result.out
    assert result.err == "ERROR: connection refused to [http://127.0.0.1:9/]\n"
    answers = {each["node"]: each for each in shell("node", "ping", "-a", "--json").records}
    assert answers["/gone"]["reply_ms"] is None
    assert "cannot be reached" in answers["/gone"]["error"]


def test_ping_without_a_node_shows_the_usage(shell: Shell) -> None:
    assert "give a node;" in shell.failure("node", "ping", code=2)
    assert "omit the node's name" in shell.failure("node", "ping", "--all", "/a", code=2)


def test_kill_ends_nodes(graph: LiveGraph, shell: Shell) -> None:
    nodes = [graph.node("a"), graph.node("b"), graph.node("c")]
    assert shell.output("node", "kill", "a") == "killing /a\nkilled\n"
    assert "user request" in graph.do(nodes[0].wait_closed())
    assert shell.output("node", "kill", "-a") == "killing:\n * /b\n * /c\nkilled\n"
    for node in nodes:
        graph.do(node.wait_closed())
    assert shell.output("node", "kill", "-a") == "No nodes running\n"


def test_kill_lets_one_choose(graph: LiveGraph, shell: Shell) -> None:
    graph.node("a")
    second = graph.node("b")
    result = shell("node", "kill", stdin="x\n3\n2\n")
    assert result.code == 0
    assert result.out.startswith("1. /a\n2. /b\n\nPlease enter the number of the node you wish to kill.\n> ")
    assert result.err.count("from 1 to 2") == 2
    graph.do(second.wait_closed())
    assert shell("node", "kill", stdin="").code == 130


def test_kill_of_the_unknown_and_the_gone(gone: str, shell: Shell) -> None:
    assert shell.failure("node", "kill", "/gonne") == "no node is called /gonne; did you mean /gone?"
    result = shell("node", "kill", gone)
    assert result.code == 1
    assert "`rostether node cleanup` removes it" in result.err


def test_kill_of_a_node_whose_host_is_unknown(graph: LiveGraph, shell: Shell) -> None:
    async def register() -> None:
        async with closed_at_end(MasterClient(graph.uri, "/lost")) as master:
            await master.register_publisher("/chatter", TEXT.name, "http://robot.invalid:9/")

    graph.do(register())
    result = shell("node", "kill", "/lost")
    assert result.code == 1
    assert "/lost: node /lost at http://robot.invalid:9/ cannot be reached" in result.err


@pytest.mark.parametrize(("arguments", "stdin"), [((), "maybe\ny\n"), (("--yes",), "")])
def test_cleanup_unregisters_the_dead_only(
    gone: str, talker: str, shell: Shell, arguments: tuple[str, ...], stdin: str
) -> None:
    printed = shell.output("node", "cleanup", *arguments, stdin=stdin)
    assert "Unable to contact the following nodes:\n * /gone\n" in printed
    assert printed.endswith("Unregistering /gone\ndone\n")
    assert shell.output("node", "list") == "/talker\n"
    assert shell.output("service", "list") == "/enable\n"
    assert shell.output("node", "cleanup") == "/talker answers\n"


def test_cleanup_can_be_declined(gone: str, shell: Shell) -> None:
    assert shell.output("node", "cleanup", stdin="n\n").endswith("aborting\n")
    assert shell("node", "cleanup", stdin="").code == 130
    assert shell.output("node", "list") == "/gone\n"


def test_machine(talker: str, shell: Shell) -> None:
    assert shell.output("node", "machine") == "127.0.0.1\n"
    assert shell.output("node", "machine", "127.0.0.1") == "/talker\n"
    # The node gave its address to the master.
    assert shell.output("node", "machine", "localhost") == "/talker\n"
    assert shell("node", "machine", "192.0.2.1").code == 1


def test_without_a_master_the_next_step_is_named(shell: Shell) -> None:
    for arguments in (("list",), ("info", "/a"), ("ping", "/a"), ("kill", "/a"), ("cleanup",), ("machine",)):
        line = shell.failure("node", *arguments)
        assert line.startswith("no ROS master answers at http://127.0.0.1:9; start one with `rostether core`")
