from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from rostether.cli.shell.own_command import CALLED_AS_VARIABLE
from rostether.errors import ServiceCallError
from rostether.graph.ports import ServiceServer
from rostether.msgdef.registry import Registry
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.node import Ros1Graph
from rostether.serde.store import TypeStore
from unit.cli.command_shell import STORE, LiveGraph, Shell

SET_BOOL = STORE.registry.service_type("std_srvs/SetBool")
EMPTY = STORE.registry.service_type("std_srvs/Empty")


async def set_led(request: bytes) -> bytes:
    is_on = STORE.codec("std_srvs/SetBoolRequest").decode(request).data
    answer = {"success": is_on, "message": "on" if is_on else "off"}
    return STORE.codec("std_srvs/SetBoolResponse").encode(answer)


async def do_nothing(_request: bytes) -> bytes:
    return b""


@pytest.fixture
def board(graph: LiveGraph) -> Ros1Graph:
    node = graph.node("board")
    graph.do(node.advertise_service("/set_led", SET_BOOL, set_led))
    graph.do(node.advertise_service("/board/reset", EMPTY, do_nothing))
    return node


@pytest.fixture
def gone(graph: LiveGraph, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of a service whose node ended without unregistering."""
    # The master's check of its nodes would remove it during a test.
    monkeypatch.setattr("rostether.ros1.master.node_calls._REFUSALS_UNTIL_GONE", 10**9)

    async def register() -> None:
        master = MasterClient(graph.uri, "/gone")
        await master.register_service("/lost", "rosrpc://127.0.0.1:9", "http://127.0.0.1:9/")
        await master.close()

    graph.do(register())
    return "/lost"


def test_list(board: Ros1Graph, shell: Shell) -> None:
    assert shell.output("service", "list") == "/board/reset\n/set_led\n"
    assert shell.output("service", "list", "board") == "/board/reset\n"
    assert shell.output("service", "list", "-n", "/set_led") == "/set_led /board\n"
    records = shell("service", "list", "--json").records
    assert records[1] == {"service": "/set_led", "nodes": ["/board"]}


def test_details_of_a_service(graph: LiveGraph, board: Ros1Graph, shell: Shell) -> None:
    uri = shell.output("service", "uri", "set_led").strip()
    assert uri.startswith("rosrpc://127.0.0.1:")
    assert shell.output("service", "type", "/set_led") == "std_srvs/SetBool\n"
    assert shell.output("service", "node", "/set_led") == "/board\n"
    assert shell.output("service", "args", "/set_led") == "data\n"
    assert shell.output("service", "args", "/board/reset") == "\n"
    assert shell.output("service", "info", "/set_led") == (
        f"Node: /board\nURI: {uri}\nType: std_srvs/SetBool\nArgs: data\n"
    )
    assert shell("service", "info", "--json", "/set_led").records == [
        {"service": "/set_led", "node": "/board", "uri": uri, "type": "std_srvs/SetBool", "args": ["data"]}
    ]


def test_find_skips_services_that_do_not_answer(
    board: Ros1Graph, gone: str, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert shell.output("service", "find", "std_srvs/SetBool") == "/set_led\n"
    assert shell.output("service", "find", "std_srvs/Trigger") == ""
    monkeypatch.setenv(CALLED_AS_VARIABLE, "rosservice")
    assert shell.output("service", "find", "std_srvs/Trigger") == "\n"


@pytest.mark.parametrize(
    ("arguments", "response"),
    [
        (("/set_led", "{data: true}"), 'success: True\nmessage: "on"\n'),
        (("set_led", "data: false"), 'success: False\nmessage: "off"\n'),
        (("/set_led", "true"), 'success: True\nmessage: "on"\n'),
        (("-v", "/set_led", "1"), 'data: True\n---\nsuccess: True\nmessage: "on"\n'),
        (("/board/reset",), "\n"),
        (("--json", "/set_led", "{}"), '{"success": false, "message": "off"}\n'),
    ],
)
def test_call_prints_what_rosservice_prints(
    board: Ros1Graph, shell: Shell, arguments: tuple[str, ...], response: str
) -> None:
    assert shell.output("service", "call", *arguments) == response


@pytest.mark.parametrize("type_name", ["std_srvs/SetBool", "std_srvs/srv/SetBool"])
def test_call_accepts_the_type_as_ros2_does(board: Ros1Graph, shell: Shell, type_name: str) -> None:
    printed = shell.output("service", "call", "/set_led", type_name, "{data: true}")
    assert printed == 'success: True\nmessage: "on"\n'


def test_call_reads_requests_from_a_pipe(board: Ros1Graph, shell: Shell) -> None:
    printed = shell.output("service", "call", "/set_led", stdin="data: true\n---\n[false]\n---\n")
    assert printed == 'success: True\nmessage: "on"\nsuccess: False\nmessage: "off"\n'


def test_call_of_a_service_whose_type_is_not_known_here(
    graph: LiveGraph, shell: Shell, tmp_path: Path
) -> None:
    (tmp_path / "my_srvs").mkdir()
    (tmp_path / "my_srvs" / "Add.srv").write_text("int32 a\nint32 b\n---\nint32 sum\n")
    registry = Registry([tmp_path])
    store = TypeStore(registry)

    async def add(request: bytes) -> bytes:
        terms = store.codec("my_srvs/AddRequest").decode(request)
        return store.codec("my_srvs/AddResponse").encode({"sum": terms.a + terms.b})

    server = graph.node("adder").advertise_service("/add", registry.service_type("my_srvs/Add"), add)
    graph.do(server)
    for verb in ("args", "info", "call"):
        assert "my_srvs" in (line := shell.failure("service", verb, "/add"))
        assert "--msg-path" in line
    assert shell.output("service", "call", "--msg-path", str(tmp_path), "/add", "-2", "3") == "sum: 1\n"
    assert shell.output("service", "args", "--msg-path", str(tmp_path), "/add") == "a b\n"


@pytest.mark.parametrize("verb", ["args", "info"])
def test_definitions_are_searched_beside_the_event_loop(
    board: Ros1Graph, shell: Shell, tmp_path: Path, verb: str, searching_threads: list[threading.Thread]
) -> None:
    shell.output("service", verb, "--msg-path", str(tmp_path), "/set_led")
    assert [each.name for each in searching_threads] == ["definitions"] * 2


def test_call_without_a_request_names_the_fields(board: Ros1Graph, shell: Shell) -> None:
    line = shell.failure("service", "call", "/set_led", code=2)
    assert line == "give the request as YAML; the fields of std_srvs/SetBool are {data: bool}"


def test_wrong_fields_name_the_right_ones(board: Ros1Graph, shell: Shell) -> None:
    assert "data" in shell.failure("service", "call", "/set_led", "{dta: true}")
    assert "1 value (data)" in shell.failure("service", "call", "/set_led", "1", "2")
    assert "is not YAML" in shell.failure("service", "call", "/set_led", "{data: ")


def test_unknown_services_name_the_nearest(board: Ros1Graph, shell: Shell) -> None:
    for verb in ("type", "uri", "node", "args", "info", "call"):
        line = shell.failure("service", verb, "/setled")
        assert line == "no node offers the service /setled; did you mean /set_led?"
    assert "`rostether service list`" in shell.failure("service", "type", "/x")


def test_a_service_that_has_ended_is_reported(board: Ros1Graph, gone: str, shell: Shell) -> None:
    for verb in ("type", "args", "call"):
        assert "`rostether node cleanup`" in shell.failure("service", verb, gone)
    result = shell("service", "info", gone)
    assert result.code == 1
    assert result.out == "Node: /gone\nURI: rosrpc://127.0.0.1:9\n"


def serve(graph: LiveGraph, name: str, handler: Callable[[bytes], Awaitable[bytes]]) -> ServiceServer:
    return graph.do(graph.node(f"server_of{name}").advertise_service(name, EMPTY, handler))


def test_the_servers_own_error_is_reported(graph: LiveGraph, shell: Shell) -> None:
    async def fail(_request: bytes) -> bytes:
        raise ServiceCallError("the motor is hot")

    async def fail_silently(_request: bytes) -> bytes:
        raise ServiceCallError("")

    serve(graph, "/turn", fail_silently)
    assert "no reason given;" in shell.failure("service", "call", "/turn")
    serve(graph, "/move", fail)
    assert "the motor is hot" in shell.failure("service", "call", "/move")


def test_timeout(graph: LiveGraph, shell: Shell) -> None:
    async def hang(_request: bytes) -> bytes:
        await asyncio.Event().wait()
        return b""

    serve(graph, "/hang", hang)
    assert "did not answer within 0.2 s" in shell.failure("service", "call", "--timeout", "0.2", "/hang")
    line = shell.failure("service", "call", "--wait", "--timeout", "0.2", "/nothing")
    assert line.startswith("no node offered the service /nothing within 0.2 s; `rostether service list`")


def test_wait_for_a_service(graph: LiveGraph, shell: Shell) -> None:
    node = graph.node("late")

    async def advertise_when_asked_for() -> None:
        await asyncio.sleep(0.3)
        await node.advertise_service("/late", EMPTY, do_nothing)

    task = graph.begin(advertise_when_asked_for())
    assert shell.output("service", "call", "--wait", "--timeout", "20", "/late") == "\n"
    task.result(60)


def test_without_a_master_the_next_step_is_named(shell: Shell) -> None:
    for verb in ("list", "type", "uri", "node", "args", "info", "call", "find"):
        line = shell.failure("service", verb, *(() if verb == "list" else ("/a",)))
        assert "start one with `rostether core`" in line
