from __future__ import annotations

import pytest

from rostether.errors import InvalidNameError
from rostether.names.resolve import resolve_name, resolve_remappings


def resolve(name: str, **remappings: str) -> str:
    return resolve_name(name, namespace="/ns", node_name="/ns/node", remappings=remappings)


@pytest.mark.parametrize(
    ("name", "resolved"),
    [
        ("a", "/ns/a"),
        ("a/b", "/ns/a/b"),
        ("/a", "/a"),
        ("/a/", "/a"),
        ("~a", "/ns/node/a"),
        ("~/a", "/ns/node/a"),
        ("~", "/ns/node"),
        ("", "/ns"),
        ("/", "/"),
        ("a//b", "/ns/a/b"),
    ],
)
def test_names_resolve_as_in_ros(name: str, resolved: str) -> None:
    assert resolve(name) == resolved


def test_the_root_namespace_adds_no_slash() -> None:
    assert resolve_name("a", namespace="/", node_name="/node") == "/a"
    assert resolve_name("~a", namespace="/", node_name="/node") == "/node/a"
    assert resolve_name("", namespace="/", node_name="/node") == "/"


def test_a_namespace_without_its_slash_is_global() -> None:
    assert resolve_name("a", namespace="ns", node_name="/ns/node") == "/ns/a"


def test_remapping_follows_resolution_and_happens_once() -> None:
    remappings = {"/ns/a": "/b", "/b": "/c"}
    assert resolve_name("a", namespace="/ns", node_name="/n", remappings=remappings) == "/b"
    assert resolve_name("/ns/a", namespace="/", node_name="/n", remappings=remappings) == "/b"
    assert resolve_name("a", namespace="/", node_name="/n", remappings=remappings) == "/a"


def test_both_sides_of_a_remapping_are_resolved() -> None:
    raw = {"servo_control": "servo_pose", "~scan": "/scan", "/x": "~y"}
    assert resolve_remappings(raw, namespace="/ns", node_name="/ns/node") == {
        "/ns/servo_control": "/ns/servo_pose",
        "/ns/node/scan": "/scan",
        "/x": "/ns/node/y",
    }


@pytest.mark.parametrize("name", ["a b", "1", "a-b", "a~b"])
def test_illegal_names_do_not_resolve(name: str) -> None:
    with pytest.raises(InvalidNameError):
        resolve(name)


def test_a_private_name_needs_a_node() -> None:
    with pytest.raises(InvalidNameError, match="private"):
        resolve_name("~a", namespace="/", node_name="")
