"""The parameter tree, and the watchers that receive its changes."""

from __future__ import annotations

import pytest

from rostether.errors import GraphError, UnknownNameError
from rostether.ros1.graph_limits import GraphLimits
from rostether.ros1.long_work import run_at_once
from rostether.ros1.master.parameter_tree import MAX_DEPTH, ParameterTree, Update, updates, watch_key
from rostether.xmlrpc.values import XmlRpcValue


def delete(tree: ParameterTree, name: str) -> None:
    run_at_once(tree.delete_steps(name))


def tree_of(**values: XmlRpcValue) -> ParameterTree:
    tree = ParameterTree()
    for name, value in values.items():
        tree.set(f"/{name}", value)
    return tree


def test_values_and_namespaces_are_found() -> None:
    tree = ParameterTree()
    tree.set("/a/b/c", 1)
    tree.set("/a/d", [1, "x"])
    assert tree.get("/a/b/c") == 1
    assert tree.get("/a/b/") == {"c": 1}
    assert tree.get("/a") == {"b": {"c": 1}, "d": [1, "x"]}
    assert tree.get("/") == {"a": {"b": {"c": 1}, "d": [1, "x"]}}
    assert [name for name in tree.names() if name] == ["/a/b/c", "/a/d"]
    assert tree.has("/a/b")
    assert tree.has("/")
    assert not tree.has("/a/b/c/d")


def test_a_dict_replaces_the_namespace() -> None:
    tree = tree_of(a={"x": 1, "y": 2})
    tree.set("/a", {"y": 3})
    assert tree.get("/a") == {"y": 3}
    tree.set("/", {"z": 1})
    assert [name for name in tree.names() if name] == ["/z"]


def test_a_value_above_a_new_parameter_becomes_a_namespace() -> None:
    tree = tree_of(a=1)
    tree.set("/a/b", 2)
    assert tree.get("/") == {"a": {"b": 2}}


def test_an_empty_namespace_is_set_but_has_no_names() -> None:
    tree = tree_of(a={})
    assert tree.has("/a")
    assert [name for name in tree.names() if name] == []


@pytest.mark.parametrize("name", ["/none", "/a/none", "/a/x/y", "/l/0"])
def test_what_is_not_set_is_unknown(name: str) -> None:
    tree = tree_of(a={"x": "text"}, l=[1])
    with pytest.raises(UnknownNameError, match=f"parameter {name} is not set"):
        tree.get(name)
    with pytest.raises(UnknownNameError):
        delete(tree, name)


def test_deleting() -> None:
    tree = tree_of(a={"x": 1, "y": {"z": 2}})
    delete(tree, "/a/y/z")
    assert tree.get("/a") == {"x": 1, "y": {}}
    delete(tree, "/a")
    assert tree.get("/") == {}
    with pytest.raises(UnknownNameError):
        delete(tree, "/")


@pytest.mark.parametrize(
    ("namespace", "key", "found"),
    [
        ("/robot/arm", "speed", "/robot/speed"),
        ("/robot", "speed", "/robot/speed"),
        ("/other", "speed", "/speed"),
        ("/", "speed", "/speed"),
        ("/robot/arm/deep", "gains/none", "/robot/arm/gains/none"),
        ("/robot", "gains/p", None),
        ("/robot", "/speed", "/speed"),
        ("/robot", "/none", None),
        ("/robot", "none", None),
    ],
)
def test_search_goes_upward_and_matches_the_first_part(namespace: str, key: str, found: str | None) -> None:
    tree = tree_of(speed=1, robot={"speed": 2, "arm": {"gains": {"p": 1}}})
    assert tree.search(namespace, key) == found


@pytest.mark.parametrize("value", [1, "x", [], None])
def test_the_root_is_a_namespace(value: XmlRpcValue) -> None:
    with pytest.raises(GraphError, match="root of parameter tree"):
        ParameterTree().set("/", value)


@pytest.mark.parametrize("value", [None, [None], {"a": {"b": None}}])
def test_nil_cannot_be_set(value: XmlRpcValue) -> None:
    with pytest.raises(GraphError, match="cannot be nil"):
        ParameterTree().set("/a", value)


def test_depth_is_bounded_by_name_and_value_together() -> None:
    tree = ParameterTree()
    value: XmlRpcValue = 1
    for _ in range(MAX_DEPTH - 1):
        value = {"x": value}
    tree.set("/a", value)
    for name in ("/a/b", "/x" * (MAX_DEPTH + 1)):
        with pytest.raises(GraphError, match="nested deeper"):
            tree.set(name, value)
    assert [name for name in tree.names() if name] == ["/a" + "/x" * (MAX_DEPTH - 1)], (
        "a refused value leaves nothing behind"
    )


def test_the_size_is_limited_and_decreases_after_a_deletion() -> None:
    tree = ParameterTree(GraphLimits(parameters_bytes=5000, parameter_bytes=6000))
    for _ in range(100):
        tree.set("/a/b/text", "x" * 2000)
        tree.set("/a/b", 1)
        tree.set("/a", {"text": b"x" * 2000})
        tree.set("/a/text/more", 1)
        delete(tree, "/a")
        tree.set("/", {"big": "x" * 2000})
        tree.set("/", {})
    assert tree._bytes == ParameterTree()._bytes
    with pytest.raises(GraphError, match="more than 5000 bytes;"):
        tree.set("/a", ["x" * 1000] * 5)
    with pytest.raises(GraphError, match="/a would need more than 6000 bytes;"):
        tree.set("/a", "x" * 6000)
    assert [name for name in tree.names() if name] == []


@pytest.mark.parametrize("again", [1, 5])
def test_size_is_right_after_changes_between_the_steps_of_another(again: int) -> None:
    large: XmlRpcValue = [[1] * 2000 for _ in range(10)]
    tree = ParameterTree()
    empty = (tree._bytes, tree._values)
    tree.set("/a", {"b": large})
    deleting = tree.delete_steps("/a")
    for number, _ in enumerate(deleting):
        if number % 3 == 0 and number < 3 * again:
            tree.set("/a/b", [[1] * 2000 for _ in range(10 + number)])
    assert (tree._bytes, tree._values) == empty
    tree.set("/a", large)
    setting = tree.set_steps("/a/b/c", 1)
    next(setting)
    delete(tree, "/a")
    list(setting)
    delete(tree, "/a")
    assert (tree._bytes, tree._values) == empty


def test_what_is_deleted_between_the_steps_of_another_is_not_set() -> None:
    tree = ParameterTree()
    tree.set("/a", [[1] * 2000 for _ in range(10)])
    deleting = tree.delete_steps("/a")
    next(deleting)
    delete(tree, "/a")
    with pytest.raises(UnknownNameError, match="parameter /a is not set"):
        list(deleting)


def test_watchers_at_and_above_receive_the_change_itself() -> None:
    assert updates(["/", "/a/", "/a/b/", "/ab/", "/a/b/c/", "/x/"], "/a/b", 5) == [
        Update("/a/b/c/", "/a/b/c/", {}, is_own_change=False),
        Update("/", "/a/b/", 5, is_own_change=True),
        Update("/a/", "/a/b/", 5, is_own_change=True),
        Update("/a/b/", "/a/b/", 5, is_own_change=True),
    ]


def test_watchers_below_receive_their_own_new_value() -> None:
    value: XmlRpcValue = {"b": {"c": 1}, "d": 2}
    assert updates(["/a/b/", "/a/b/c/", "/a/d/", "/a/gone/"], "/a", value) == [
        Update("/a/gone/", "/a/gone/", {}, is_own_change=False),
        Update("/a/b/c/", "/a/b/c/", 1, is_own_change=False),
        Update("/a/b/", "/a/b/", {"c": 1}, is_own_change=False),
        Update("/a/d/", "/a/d/", 2, is_own_change=False),
    ]


def test_watchers_of_everything_receive_a_new_root() -> None:
    assert updates(["/", "/a/"], "/", {"a": 1}) == [
        Update("/a/", "/a/", 1, is_own_change=False),
        Update("/", "/", {"a": 1}, is_own_change=True),
    ]


@pytest.mark.parametrize(
    ("name", "key"), [("/", "/"), ("/a", "/a/"), ("/a/b/", "/a/b/"), ("//a//b", "/a/b/")]
)
def test_watch_keys_end_with_a_slash(name: str, key: str) -> None:
    assert watch_key(name) == key
