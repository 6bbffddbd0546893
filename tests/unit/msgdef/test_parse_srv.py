from __future__ import annotations

import pytest

from rostether.errors import DefinitionError
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.parse_srv import action_of, expand_action, parse_service
from rostether.msgdef.spec import ServiceSpec

TEXT = "int32 order\n---\nint32[] sequence\n---\nint32[] partial\n"
SEVEN = {
    "FibGoal": [("int32", "order")],
    "FibResult": [("int32[]", "sequence")],
    "FibFeedback": [("int32[]", "partial")],
    "FibActionGoal": [
        ("std_msgs/Header", "header"),
        ("actionlib_msgs/GoalID", "goal_id"),
        ("p/FibGoal", "goal"),
    ],
    "FibActionResult": [
        ("std_msgs/Header", "header"),
        ("actionlib_msgs/GoalStatus", "status"),
        ("p/FibResult", "result"),
    ],
    "FibActionFeedback": [
        ("std_msgs/Header", "header"),
        ("actionlib_msgs/GoalStatus", "status"),
        ("p/FibFeedback", "feedback"),
    ],
    "FibAction": [
        ("p/FibActionGoal", "action_goal"),
        ("p/FibActionResult", "action_result"),
        ("p/FibActionFeedback", "action_feedback"),
    ],
}


def parse(text: str) -> ServiceSpec:
    return parse_service(text, package="my_srvs", name="Foo", file="Foo.srv")


def names(text: str) -> tuple[list[str], list[str]]:
    spec = parse(text)
    return [field.name for field in spec.request.fields], [field.name for field in spec.response.fields]


def test_both_halves_are_messages() -> None:
    spec = parse("bool data # on\n---\nbool success\nstring message\n")
    assert spec.full_name == "my_srvs/Foo"
    assert spec.request.full_name == "my_srvs/FooRequest"
    assert spec.response.full_name == "my_srvs/FooResponse"
    assert spec.request.text == "bool data # on\n"
    assert spec.response.text == "bool success\nstring message\n\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("---", ([], [])),
        ("", ([], [])),
        ("int8 a", (["a"], [])),
        ("---\nint8 b", ([], ["b"])),
        ("int8 a\n--- the answer\nint8 b", (["a"], ["b"])),
        ("int8 a\n---\nint8 b\n---\nint8 c", (["a"], ["b", "c"])),
        ("int8 same\n---\nint8 same", (["same"], ["same"])),
    ],
)
def test_the_mark_separates_request_and_response(text: str, expected: tuple[list[str], list[str]]) -> None:
    assert names(text) == expected


def test_types_of_the_same_package_are_found_in_both_halves() -> None:
    spec = parse("Bar a\n---\nHeader b")
    assert spec.request.fields[0].type.base == "my_srvs/Bar"
    assert spec.response.fields[0].type.base == "std_msgs/Header"


@pytest.mark.parametrize(
    ("text", "line"), [("oops\n---\n", 1), ("int8 a\n---\nint8 b\noops", 4), ("---\noops", 2)]
)
def test_mistakes_are_reported_with_the_line_in_the_file(text: str, line: int) -> None:
    with pytest.raises(DefinitionError, match=f"Foo.srv:{line}:1:"):
        parse(text)


def test_an_action_defines_seven_messages() -> None:
    texts = expand_action(TEXT, name="Fib")
    parsed = {name: parse_message(text, package="p", name=name) for name, text in texts.items()}
    found = {name: [(str(field.type), field.name) for field in spec.fields] for name, spec in parsed.items()}
    assert found == SEVEN


@pytest.mark.parametrize("text", ["", "int32 a", "---", "---\n---\n---\n"])
def test_other_than_three_sections_is_an_error(text: str) -> None:
    with pytest.raises(DefinitionError, match=r"Fib\.action: .*parts"):
        expand_action(text, name="Fib", file="Fib.action")


def test_sections_may_be_empty() -> None:
    assert set(expand_action("---\n---", name="Fib")) == set(SEVEN)


@pytest.mark.parametrize("message", sorted(SEVEN))
def test_the_action_of_a_message_is_found(message: str) -> None:
    assert "Fib" in action_of(message)


def test_names_without_a_suffix_belong_to_no_action() -> None:
    assert action_of("Twist") == ()
    assert action_of("Goal") == ()
