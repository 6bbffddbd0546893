from __future__ import annotations

import math
from pathlib import Path

import pytest

from rostether.cli.param.ros2_params import parse_value
from rostether.ros2.parameters.typed_value import ParameterType
from unit.cli.command_shell import Shell
from unit.cli.ros2.zenoh_world import ZenohWorld

pytestmark = pytest.mark.slow


def test_list_and_get(world: ZenohWorld, shell: Shell) -> None:
    assert shell.output("param", "list") == "/far/board:\n  arm.joints\n  gain\n  use_sim_time\n"
    assert shell.output("param", "list", "far/board", "--param-type") == (
        "  arm.joints (type: integer array)\n  gain (type: double)\n  use_sim_time (type: boolean)\n"
    )
    assert shell.output("param", "list", "/far/board", "--param-prefixes", "arm") == "  arm.joints\n"
    assert shell.output("param", "get", "/far/board", "gain") == "Double value is: 1.5\n"
    assert shell.output("param", "get", "/far/board/gain", "--hide-type") == "1.5\n"
    assert (
        shell.output("param", "get", "/far/board", "arm.joints") == "Integer values are: array('q', [1, 2])\n"
    )
    assert shell("param", "get", "--json", "/far/board/arm/joints").records == [
        {"node": "/far/board", "name": "arm.joints", "value": [1, 2]}
    ]
    assert "Parameter not set" in shell.failure("param", "get", "/far/board", "nope")
    assert "Node not found" in shell.failure("param", "get", "/nope", "gain")


def test_set_and_delete(world: ZenohWorld, shell: Shell) -> None:
    assert shell.output("param", "set", "/far/board", "trim", "-5") == "Set parameter successful\n"
    assert shell.output("param", "get", "/far/board", "trim") == "Integer value is: -5\n"
    assert world.do(world.board.get_param("~trim")) == -5
    world.do(world.board.set_param("~offset", math.nan))
    assert shell("param", "get", "--json", "/far/board/offset").records == [
        {"node": "/far/board", "name": "offset", "value": "NaN"}
    ]
    shell.output("param", "delete", "/far/board", "offset")
    assert shell.output("param", "delete", "/far/board", "trim") == "Deleted parameter successfully\n"
    assert not world.do(world.board.has_param("~trim"))
    assert shell.output("param", "set", "/far/board", "a", "1", "b", "two") == (
        "a: Set parameter successful\nb: Set parameter successful\n"
    )
    for name in "ab":
        shell.output("param", "delete", f"/far/board/{name}")
    failure = shell.failure("param", "set", "/far/board", "use_sim_time", "maybe")
    assert failure.startswith("Setting parameter failed: ")


def test_describe(world: ZenohWorld, shell: Shell) -> None:
    assert shell.output("param", "describe", "/far/board", "gain") == (
        "Parameter name: gain\n  Type: double\n  Constraints:\n"
    )
    assert "--ros2 for the parameters of a ROS 2 node" in shell.failure(
        "param", "describe", "--ros1", "/far/board", "gain", code=2
    )


def test_dump_and_load(world: ZenohWorld, shell: Shell, tmp_path: Path) -> None:
    dumped = shell.output("param", "dump", "/far/board")
    assert dumped == (
        "/far/board:\n  ros__parameters:\n    arm:\n      joints:\n      - 1\n      - 2\n"
        "    gain: 1.5\n    use_sim_time: false\n\n"
    )
    file = tmp_path / "board.yaml"
    file.write_text(dumped.replace("1.5", "2.5"))
    assert shell.output("param", "load", "/far/board", str(file)) == (
        "Set parameter arm.joints successful\n"
        "Set parameter gain successful\n"
        "Set parameter use_sim_time successful\n"
    )
    assert world.do(world.board.get_param("~gain")) == 2.5
    world.do(world.board.set_param("~gain", 1.5))
    file.write_text("/other: {ros__parameters: {gain: 1.0}}")
    assert "has no parameters for /far/board" in shell.failure("param", "load", "/far/board", str(file))


def test_dump_of_a_name_that_begins_with_another(world: ZenohWorld, shell: Shell) -> None:
    shell.output("param", "set", "/far/board", "gain.low", "0.5")
    assert "    gain: 1.5\n    gain.low: 0.5\n" in shell.output("param", "dump", "/far/board")
    shell.output("param", "delete", "/far/board", "gain.low")


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("true", ParameterType.BOOL, True),
        ("5", ParameterType.INTEGER, 5),
        ("1e-3", ParameterType.DOUBLE, 0.001),
        ("[1.0, 2.0]", ParameterType.DOUBLE_ARRAY, [1.0, 2.0]),
        ("[a, b]", ParameterType.STRING_ARRAY, ["a", "b"]),
        ("[1, a]", ParameterType.STRING, "[1, a]"),
        ("a: b", ParameterType.STRING, "a: b"),
        ("2020-01-01", ParameterType.STRING, "2020-01-01"),
        ("[", ParameterType.STRING, "["),
        ("", ParameterType.STRING, ""),
    ],
)
def test_values(text: str, kind: ParameterType, value: object) -> None:
    parsed = parse_value("name", text)
    assert (parsed.type, parsed.value) == (kind, value)
