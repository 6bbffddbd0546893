from __future__ import annotations

import base64
import math
from pathlib import Path
from typing import Any

import pytest

from unit.cli.command_shell import LiveGraph, Shell

pytestmark = pytest.mark.usefixtures("graph")


def value_of(graph: LiveGraph, name: str) -> Any:
    return graph.master.api.parameters.get(name)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5", 5),
        ("-5", -5),
        ("-1.5", -1.5),
        ("2147483647", 2147483647),
        ("-2147483648", -2147483648),
        ("1.0e-3", 0.001),
        ("true", True),
        ("hello world", "hello world"),
        ("'5'", "5"),
        ("", ""),
        ("[1, [2, x]]", [1, [2, "x"]]),
        ("[{a: 1}]", [{"a": 1}]),
        ("!!binary aGk=", b"hi"),
        ("deg(180)", math.pi),
        ("deg(-90.5)", math.radians(-90.5)),
        ("!degrees 45", math.pi / 4),
        ("rad(pi/2)", math.pi / 2),
        ("rad(2*pi)", 2 * math.pi),
        ("!radians 2*pi - 1", 2 * math.pi - 1),
        ("deg(90) east", "deg(90) east"),
    ],
)
def test_a_value_is_read_as_yaml(graph: LiveGraph, shell: Shell, text: str, value: Any) -> None:
    assert shell.output("param", "set", "/x", text) == ""
    stored = value_of(graph, "/x")
    assert type(stored) is type(value)
    assert stored == (pytest.approx(value) if isinstance(value, float) else value)


def test_a_mapping_changes_the_parameters_that_it_names(graph: LiveGraph, shell: Shell) -> None:
    shell.output("param", "set", "/arm", "{a: 1, b: {c: 2, d: 3}}")
    assert shell.output("param", "set", "-v", "arm", "{b: {c: 20}, /other: x}") == (
        "set parameter [/arm/b/c] to [20]\nset parameter [/other] to [x]\n"
    )
    assert value_of(graph, "/arm") == {"a": 1, "b": {"c": 20, "d": 3}}
    assert value_of(graph, "/other") == "x"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("5000000000", "parameter /x: 5000000000 needs more than the 32 bits"),
        ("{a: [-2147483649]}", "parameter /x/a: -2147483649 needs more than the 32 bits"),
        ("null", "parameter /x has no value (YAML reads it as null)"),
        ("{a: }", "parameter /x/a has no value (YAML reads it as null)"),
        ("2020-01-01", "YAML reads 2020-01-01 as a date; put it in quotes"),
        ("{1: 2}", "/x: the key 1 is not a string;"),
        ("{~a: 2}", "write the node's name instead of ~"),
        ("{a: ", ": this is not YAML"),
        ("&a {b: *a}", "endless as YAML"),
        ("&a [*a]", "endless as YAML"),
        # Too deep for newer versions of libyaml.
        ("[" * 5000, "YAML"),
        ("[" * 100_000, "too large as YAML"),
        ("!!python/object:os.system {}", "could not determine a constructor"),
        ("rad(__import__)", "__import__"),
        ("!degrees north", "'north' is not an angle"),
        ("!radians 9**9**9", "9**9**9"),
        ("a\x01b", "not YAML"),
    ],
)
def test_wrong_values_are_refused_in_one_line(graph: LiveGraph, shell: Shell, text: str, words: str) -> None:
    assert words in shell.failure("param", "set", "/x", text)
    assert not graph.master.api.parameters.has("/x")


def test_probable_mistakes_are_reported(graph: LiveGraph, shell: Shell) -> None:
    assert "an exponent needs a dot" in shell("param", "set", "/x", "1e-3").err
    assert value_of(graph, "/x") == "1e-3"
    assert "sets nothing" in shell("param", "set", "/x", "{}").err
    assert value_of(graph, "/x") == "1e-3"


def test_names_that_break_the_rules_can_be_read_and_deleted(graph: LiveGraph, shell: Shell) -> None:
    result = shell("param", "set", "/a-b/1st", "5")
    assert (result.code, result.err.count("is not a ROS name")) == (0, 1)
    assert shell.output("param", "get", "a-b/1st") == "5\n"
    assert shell.output("param", "list", "/a-b") == "/a-b/1st\n"
    shell.output("param", "delete", "/a-b")
    assert not graph.master.api.parameters.has("/a-b")


def test_set_from_files(graph: LiveGraph, shell: Shell, tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_bytes("<robot name='ä'/>\n".encode())
    shell.output("param", "set", "/text", "-t", str(file))
    shell.output("param", "set", "/bytes", "--binfile", str(file))
    assert value_of(graph, "/text") == "<robot name='ä'/>\n"
    assert value_of(graph, "/bytes") == file.read_bytes()
    encoded = base64.b64encode(file.read_bytes()).decode()
    assert shell("param", "get", "/bytes", "--json").records == [{"name": "/bytes", "value": encoded}]
    assert "No such file" in shell.failure("param", "set", "/x", "-t", str(tmp_path / "none"))
    assert "No such file" in shell.failure("param", "set", "/x", "-b", str(tmp_path / "none"))
    assert "give a value, or a file" in shell.failure("param", "set", "/x", code=2)
    assert "give a value, or a file" in shell.failure("param", "set", "/x", "1", "-t", "a", code=2)
    file.write_bytes(b"\xff")
    assert "not UTF-8" in shell.failure("param", "set", "/x", "-t", str(file))


def test_get_prints_yaml(graph: LiveGraph, shell: Shell) -> None:
    shell.output("param", "set", "/tree", "{b: [1, 2], a: {s: 'x: y', t: true}, c: ''}")
    assert shell.output("param", "get", "/tree/a/t") == "true\n"
    assert shell.output("param", "get", "/tree/a/s") == "'x: y'\n\n"
    assert shell.output("param", "get", "tree") == ("a:\n  s: 'x: y'\n  t: true\nb:\n- 1\n- 2\nc: ''\n\n")
    assert shell.output("param", "get", "-v", "/tree/a/t") == "getting parameter [/tree/a/t]\ntrue\n"


@pytest.mark.parametrize(
    ("typed", "printed"),
    [
        ("hello", "hello\n"),
        ("", "''\n\n"),
        ("'5'", "'5'\n\n"),
        ("rad(pi/2)", "1.5707963267948966\n"),
        ("[1, two, 3.5]", "- 1\n- two\n- 3.5\n\n"),
        ("[]", "[]\n\n"),
        ("!!binary aGVsbG8=", "!!binary |\n  aGVsbG8=\n\n"),
    ],
)
def test_get_prints_what_was_set(shell: Shell, typed: str, printed: str) -> None:
    shell.output("param", "set", "/value", typed)
    assert shell.output("param", "get", "/value") == printed


def test_get_pretty(graph: LiveGraph, shell: Shell) -> None:
    graph.master.api.parameters.set("/tree", {"b": 2.5, "a": {"s": "x: y", "m": "one\ntwo"}})
    assert shell.output("param", "get", "-p", "/tree") == (
        "a:\n  m: |\n    one\n    two\n  s: x: y\nb: 2.5\n"
    )
    assert shell.output("param", "get", "-p", "/tree/a/s") == "x: y\n"


def test_get_as_json(graph: LiveGraph, shell: Shell) -> None:
    graph.master.api.parameters.set("/tree", {"n": math.nan, "l": [math.inf, 1.5], "s": "ä"})
    assert shell("param", "get", "--json", "/tree").records == [
        {"name": "/tree", "value": {"n": "NaN", "l": ["Infinity", 1.5], "s": "ä"}}
    ]


def test_unknown_names_get_the_nearest(graph: LiveGraph, shell: Shell) -> None:
    shell.output("param", "set", "/board/blink_hz", "2.5")
    for verb in ("get", "delete"):
        line = shell.failure("param", verb, "/board/blink_h")
        assert line == "parameter /board/blink_h is not set; did you mean /board/blink_hz?"
    assert "did you mean /board?" in shell.failure("param", "dump", "-", "/bord")
    assert "`rostether param list`" in shell.failure("param", "get", "/quite/another")


def test_list(graph: LiveGraph, shell: Shell) -> None:
    shell.output("param", "set", "/b", "{y: 1, x: {z: 2}}")
    shell.output("param", "set", "/bb", "1")
    assert shell.output("param", "list", "/b") == "/b/x/z\n/b/y\n"
    assert shell.output("param", "list") == "/b/x/z\n/b/y\n/bb\n/rosdistro\n/rosversion\n/run_id\n"
    assert shell("param", "list", "--json", "b").records == [{"name": "/b/x/z"}, {"name": "/b/y"}]
    assert shell.output("param", "list", "/nothing") == ""


def test_delete(graph: LiveGraph, shell: Shell) -> None:
    shell.output("param", "set", "/b", "{y: 1, x: 2}")
    assert shell.output("param", "delete", "/b/y") == ""
    assert shell.output("param", "delete", "-v", "b") == "deleted parameter [/b]\n"
    assert shell.output("param", "delete", "-v", "/") == "deleted ENTIRE parameter server\n"
    assert shell.output("param", "list") == ""


def test_dump_and_load_are_each_others_inverse(graph: LiveGraph, shell: Shell, tmp_path: Path) -> None:
    tree: dict[str, Any] = {
        "i": 1,
        "f": 1.5,
        "s": "deg(1)x",
        "n": "5",
        "l": [1, "a", [True]],
        "t": {"u": "ä\n b"},
        "b": b"\0",
    }
    graph.master.api.parameters.set("/from", tree)
    file = tmp_path / "params.yaml"
    assert shell.output("param", "dump", str(file), "/from") == ""
    assert shell.output("param", "dump", "-", "from") == file.read_text()
    assert shell.output("param", "load", str(file), "/to") == ""
    assert value_of(graph, "/to") == tree
    shell.output("param", "load", "-", "again", stdin=file.read_text())
    assert value_of(graph, "/again") == tree


def test_a_failed_dump_leaves_the_file_alone(shell: Shell, tmp_path: Path) -> None:
    file = tmp_path / "params.yaml"
    file.write_text("precious: 1\n")
    shell.failure("param", "dump", str(file), "/nothing")
    assert file.read_text() == "precious: 1\n"
    assert "No such file" in shell.failure("param", "dump", str(tmp_path / "no" / "where"), "/")


def test_load_accepts_several_documents_and_namespaces(
    graph: LiveGraph, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = "_ns: left\ngain: 1\n---\n---\n_ns: /right\ngain: 2\n---\ngain: 3\n/top: 4\n"
    shell.output("param", "load", "-", "/arm", stdin=text)
    assert value_of(graph, "/arm") == {"left": {"gain": 1}, "gain": 3}
    assert (value_of(graph, "/right/gain"), value_of(graph, "/top")) == (2, 4)
    monkeypatch.setenv("ROS_NAMESPACE", "lab")
    shell.output("param", "load", "-", stdin="gain: 5\n")
    assert shell.output("param", "get", "gain") == "5\n"
    assert value_of(graph, "/lab/gain") == 5


def test_a_mistake_in_a_file_sets_nothing(graph: LiveGraph, shell: Shell, tmp_path: Path) -> None:
    before = value_of(graph, "/")
    file = tmp_path / "params.yaml"
    for text, words in (
        ("good: 1\nbad: 2020-01-01\n", "parameter /bad: YAML reads"),
        ("good: 1\nbad: [1\n", f"{file}:3:1: this is not YAML"),
        ("- 1\n", "/ can only be set to a mapping"),
    ):
        file.write_text(text)
        assert words in shell.failure("param", "load", str(file))
    assert "give a file in this folder" in shell.failure("param", "load", str(tmp_path))
    assert value_of(graph, "/") == before


def test_without_a_master_the_next_step_is_named(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")
    for arguments in (("list",), ("get", "/a"), ("set", "/a", "1"), ("delete", "/a"), ("dump",)):
        assert "start one with `rostether core`" in shell.failure("param", *arguments)
