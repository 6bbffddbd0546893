from __future__ import annotations

import pytest

from rostether.errors import InvalidNameError
from rostether.names.graph_name import (
    as_namespace,
    canonical,
    is_global,
    is_legal_name,
    is_private,
    join,
    namespace_of,
    resolve_name,
    resolve_remappings,
    validate_name,
)

LEGAL = ["a", "/", "/a", "/a/b", "a/b_1", "~a", "~", "A9", "/a/", "~/a", "a__b"]
ILLEGAL = ["1a", "_a", "a b", "a-b", "/a//b", "//", "a~b", "a.b", "a\n", "grün", "/a:b", "a\x00"]


@pytest.mark.parametrize("name", LEGAL)
def test_legal_names_are_accepted_unchanged(name: str) -> None:
    assert is_legal_name(name)
    assert validate_name(name) == name


@pytest.mark.parametrize("name", ILLEGAL)
def test_illegal_names_are_refused_with_one_line(name: str) -> None:
    assert not is_legal_name(name)
    with pytest.raises(InvalidNameError) as raised:
        validate_name(name)
    assert "\n" not in str(raised.value)


def test_the_empty_name_is_legal_but_names_nothing() -> None:
    assert is_legal_name("")
    with pytest.raises(InvalidNameError, match="empty"):
        validate_name("")


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("1a", "must start with"),
        ("a-b", "'-' is not a letter"),
        ("a//b", "empty part"),
        ("a\nb", r"'\\n' is not"),
        ("a~b", "'~' is not"),
    ],
)
def test_the_reason_is_named(name: str, reason: str) -> None:
    with pytest.raises(InvalidNameError, match=reason):
        validate_name(name)


def test_the_error_about_a_long_name_is_short() -> None:
    with pytest.raises(InvalidNameError) as raised:
        validate_name("a" * 100_000 + "-")
    assert len(str(raised.value)) < 200


@pytest.mark.parametrize(
    ("namespace", "name", "joined"),
    [
        ("/", "a", "/a"),
        ("/ns", "a", "/ns/a"),
        ("/ns/", "a", "/ns/a"),
        ("ns", "a", "ns/a"),
        ("", "a", "a"),
        ("~", "a", "~a"),
        ("/ns", "/a", "/a"),
        ("/ns", "~a", "~a"),
    ],
)
def test_join(namespace: str, name: str, joined: str) -> None:
    assert join(namespace, name) == joined


@pytest.mark.parametrize(
    ("name", "namespace"), [("/a", "/"), ("/a/b", "/a"), ("/a/b/", "/a"), ("/", "/"), ("", "/"), ("a/b", "a")]
)
def test_namespace_of(name: str, namespace: str) -> None:
    assert namespace_of(name) == namespace


@pytest.mark.parametrize(
    ("name", "cleaned"),
    [("/a//b/", "/a/b"), ("//", "/"), ("a/", "a"), ("", ""), ("~a//b", "~a/b")],
)
def test_canonical(name: str, cleaned: str) -> None:
    assert canonical(name) == cleaned


def test_global_and_private() -> None:
    assert is_global("/a")
    assert not is_global("a")
    assert is_private("~a")
    assert not is_private("/a")


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


@pytest.mark.parametrize(("name", "namespace"), [("/", "/"), ("a//b", "/a/b/"), ("/a/", "/a/"), ("", "/")])
def test_names_as_namespaces(name: str, namespace: str) -> None:
    assert as_namespace(name) == namespace
