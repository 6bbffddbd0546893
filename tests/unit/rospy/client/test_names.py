from __future__ import annotations

import pytest

from rostether.rospy.client.exceptions import ROSInitException
from rostether.rospy.client.names import NodeNames, is_remap_argument
from rostether.rospy.tools import graph_names


def test_before_init_node() -> None:
    names = NodeNames(["a:=/b", "x", "_rate:=[1, 2]"], {"ROS_NAMESPACE": "lab"})
    assert (names.namespace, names.caller_id) == ("/lab/", "/lab/unnamed")
    assert names.resolve_early("a") == "/b"
    assert names.resolve_early("/lab/a") == "/b"
    assert names.resolve_early("c") == "/lab/c"
    assert names.private_params == {"rate": [1, 2]}
    with pytest.raises(ValueError, match="~name topics"):
        names.resolve_early("~a")


def test_remapped_to_a_private_name_too_early() -> None:
    with pytest.raises(ROSInitException):
        NodeNames(["a:=~b"], {}).resolve_early("a")


def test_after_init_node() -> None:
    names = NodeNames(["a:=b/c", "~in:=/out", "/x:=y", "__ns:=robot"], {})
    assert names.set_node_name("node") == "/robot/node"
    assert names.resolve("a") == "/robot/b/c"
    assert names.resolve("~in") == "/out"
    assert names.resolve("~other") == "/robot/node/other"
    assert names.resolve("/x/") == "/robot/y"
    assert names.resolve("") == "/robot/"
    assert names.remap("a") == "/robot/b/c"
    assert names.remap("q") == "q"


def test_special_names_are_not_topics() -> None:
    names = NodeNames(["__name:=other", "__log:=/tmp/x.log"], {})
    names.set_node_name("node")
    assert names.mappings["__name"] == "other"
    assert names.resolve("__name") != "other"


@pytest.mark.parametrize(
    ("argument", "is_ours"),
    [("a:=b", True), ("_p:=1", True), ("__x:=y", True), ("a=b", False), (":=b", False)],
)
def test_arguments(argument: str, is_ours: bool) -> None:
    assert is_remap_argument(argument) is is_ours


def test_a_parameter_that_is_not_yaml() -> None:
    with pytest.raises(ROSInitException, match="_p:="):
        NodeNames(["_p:=[1"], {})


@pytest.mark.parametrize(
    ("name", "caller_id", "full_name"),
    [
        ("a", "/ns/node", "/ns/a"),
        ("a", "ns/node", "ns/a"),
        ("a", "/ns//node", "/ns//a"),
        ("~a", "/n", "/n/a"),
    ],
)
def test_full_name_as_in_rosgraph(name: str, caller_id: str, full_name: str) -> None:
    assert graph_names.resolve_name(name, caller_id) == full_name
