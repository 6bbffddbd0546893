"""Full names and nodes' parameters."""

from __future__ import annotations

import pytest

from rostether.ros2.parameters.parameter_name import ParameterPath, full_name, locate

NODES = ("/board", "/lab/arm", "/lab/arm/wrist")


@pytest.mark.parametrize(
    ("name", "node", "path"),
    [
        ("/board/gain", "/board", "gain"),
        ("/board/gains/p", "/board", "gains.p"),
        ("/board", "/board", ""),
        ("/board2/gain", "/lab/me", "board2.gain"),
        ("/lab/arm/p", "/lab/arm", "p"),
        ("/lab/arm/wrist/p", "/lab/arm/wrist", "p"),
        ("/lab/arm/wrists/p", "/lab/arm", "wrists.p"),
        ("/lab/me/p", "/lab/me", "p"),
        # Below no node: a parameter of this node, without its namespace.
        ("/gain", "/lab/me", "gain"),
        ("/lab/gain", "/lab/me", "gain"),
        ("/labs/gain", "/lab/me", "labs.gain"),
        ("/", "/lab/me", ""),
    ],
)
def test_the_owner_of_a_parameter(name: str, node: str, path: str) -> None:
    assert locate(name, NODES, "/lab/me") == (node, path)


def test_the_root_namespace() -> None:
    assert locate("/gains/p", (), "/me") == ("/me", "gains.p")


@pytest.mark.parametrize(
    ("path", "name", "holds"),
    [
        ("a", "a", True),
        ("a", "a.b", True),
        ("a", "ab", False),
        ("a.b", "a", False),
        ("", "a", True),
        # Names of parameters of other nodes may have slashes.
        ("qos.parameter_events.depth", "qos./parameter_events.depth", True),
    ],
)
def test_a_path_holds_the_parameters_below_it(path: str, name: str, *, holds: bool) -> None:
    assert ParameterPath("/n", path).holds(name) is holds


def test_full_names_have_single_slashes() -> None:
    assert full_name("/lab/arm", "gains.p") == "/lab/arm/gains/p"
    assert full_name("/arm", "qos./parameter_events.depth") == "/arm/qos/parameter_events/depth"
