"""Parameter files: the nodes of an entry, the values, and invalid files."""

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.ros2.parameters.parameter_file import parse_parameters, read_parameter_files


def entry(node: str) -> str:
    return f"{node}: {{ros__parameters: {{a: 1}}}}"


@pytest.mark.parametrize(
    ("pattern", "matching", "others"),
    [
        ("/**", ["/board", "/lab/board", "/a/b/c"], []),
        ("/board", ["/board"], ["/lab/board", "/board2", "/board/x"]),
        ("board", ["/board"], ["/lab/board"]),
        ("/lab/board", ["/lab/board"], ["/board", "/lab"]),
        ("/*/board", ["/lab/board", "/x/board"], ["/board", "/a/b/board"]),
        ("/**/board", ["/board", "/lab/board", "/a/b/board"], ["/a/b/bird"]),
        ("/lab/**", ["/lab/board", "/lab/a/b"], ["/labs/board"]),
        ("/**/arm/*", ["/arm/x", "/a/arm/x"], ["/arm", "/a/arm/x/y"]),
    ],
)
def test_entries_apply_to_matching_nodes(pattern: str, matching: list[str], others: list[str]) -> None:
    rules = parse_parameters(entry(pattern), "file")
    for node in matching:
        assert rules.for_node(node) == {"a": 1}
    for node in others:
        assert rules.for_node(node) == {}


def test_namespaces_nest_and_the_last_entry_counts() -> None:
    rules = parse_parameters(
        """
lab:
  board:
    ros__parameters: {port: /dev/ttyACM0, gains: {p: 1, i: [1, 2.5]}}
/**:
  ros__parameters:
    gains.p: 2
    use_sim_time: true
""",
        "file",
    )
    assert rules.for_node("/lab/board") == {
        "port": "/dev/ttyACM0",
        "gains.p": 2,
        "gains.i": [1.0, 2.5],
        "use_sim_time": True,
    }
    assert rules.for_node("/other") == {"gains.p": 2, "use_sim_time": True}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001),
        ("1.5e3", 1500.0),
        ("-2E6", -2e6),
        ("7", 7),
        ("0x10", 16),
        ("2020-01-01", "2020-01-01"),
        ("yes", True),
        ('"7"', "7"),
        (".inf", float("inf")),
        ("[a, b]", ["a", "b"]),
        ("1e3x", "1e3x"),
    ],
)
def test_values(text: str, value: object) -> None:
    received = parse_parameters(f"n: {{ros__parameters: {{a: {text}}}}}", "file").for_node("/n")["a"]
    assert received == value
    assert type(received) is type(value)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("{", "is not YAML"),
        ("7", "has no mapping"),
        ("/board: 7", "/board holds 7"),
        ("/board:", "/board holds nothing; write node names"),
        ("/board: {gain: 7}", "/board/gain holds 7"),
        ("/board: {ros__parameters: 7}", "names with values"),
        ("/board: {ros__parameters: {a: }}", "a has no value"),
        ("/board: {ros__parameters: {a: [1, x]}}", "list of one type"),
        ("/board: {ros__parameters: {a: 99999999999999999999}}", "64-bit"),
        ("a: !!python/object:os.system {}", "is not YAML"),
        ("{a: &a {b: *a}}", "has an alias"),
        ("board:\n\tros__parameters:\n", "indent with spaces, not tabs"),
        ("ros__parameters: {a: 1}", "write the name of a node above `ros__parameters:`"),
        ("{a: " * 900 + "}" * 900, "nested too deeply|holds"),
        ("[" * 20000, "is too large as YAML"),
    ],
)
def test_invalid_files_are_refused(text: str, fault: str) -> None:
    with pytest.raises(ConfigError, match=fault) as caught:
        parse_parameters(text, "board.yaml")
    assert "board.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_too_long_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.ros2.parameters.parameter_file.MAX_FILE_BYTES", 2)
    path = tmp_path / "long.yaml"
    path.write_text("abé", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"long\.yaml has more than 2 bytes; split it"):
        read_parameter_files([path])


def test_files_are_read_in_their_order(tmp_path: Path) -> None:
    first, second, empty = tmp_path / "1.yaml", tmp_path / "2.yaml", tmp_path / "3.yaml"
    first.write_text("n: {ros__parameters: {a: 1, b: 1}}")
    second.write_text("n: {ros__parameters: {b: 2}}")
    empty.write_text("")
    assert read_parameter_files([first, second, empty]).for_node("/n") == {"a": 1, "b": 2}
    with pytest.raises(
        ConfigError, match=r"cannot read parameter file .*4\.yaml: No such file or directory; check the path"
    ):
        read_parameter_files([tmp_path / "4.yaml"])
    second.write_bytes(b"\xff")
    with pytest.raises(ConfigError, match=r"2\.yaml is not text in UTF-8; save it in UTF-8"):
        read_parameter_files([second])
