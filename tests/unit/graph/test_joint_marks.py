"""Marks of nodes that are in two graphs: what they show, and names alone do not."""

from __future__ import annotations

from rostether.graph.joint_marks import (
    MarkedNodes,
    is_mark,
    new_joint_mark,
    new_relay_mark,
    relay_marks,
    replace_names,
)
from rostether.graph.ports import Snapshot, TopicEntry
from rostether.names.graph_name import validate_name


def seen(**nodes_by_mark: tuple[str, ...]) -> Snapshot:
    return Snapshot(
        topics={mark: TopicEntry(mark, "std_msgs/Empty", nodes, ()) for mark, nodes in nodes_by_mark.items()}
    )


def test_only_nodes_with_one_mark_in_two_graphs_are_in_both() -> None:
    relay, other, joint = new_relay_mark(), new_relay_mark(), new_joint_mark()
    one = seen(
        **{relay: ("/relay",), other: ("/elsewhere",), joint: ("/board", "/late"), "/chat": ("/talker",)}
    )
    two = seen(**{relay: ("/relay",), joint: ("/board",), "/chat": ("/talker",)})
    found = MarkedNodes.find([one, two])
    assert found == MarkedNodes({"/relay": relay}, frozenset({"/board"}))
    assert found.names == {"/relay", "/board"}
    assert relay_marks(one) == {"/relay": relay, "/elsewhere": other}


def test_marks_are_names_and_show_the_age() -> None:
    older, younger = new_relay_mark(), new_relay_mark()
    assert older < younger
    for mark in (older, younger, new_joint_mark()):
        assert is_mark(mark)
        assert validate_name(mark) == mark
    assert not is_mark("/rostether/other")


def test_a_set_keeps_unchanged_names() -> None:
    names = {"/a", "/b"}
    same = names
    replace_names(names, {"/b", "/c"})
    assert same == {"/b", "/c"}
