from __future__ import annotations

import pytest

from rostether.errors import DefinitionError
from rostether.msgdef.parse_action import action_of, expand_action
from rostether.msgdef.parse_msg import parse_message

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


def test_an_action_stands_for_seven_messages() -> None:
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
def test_a_message_leads_to_its_action(message: str) -> None:
    assert "Fib" in action_of(message)


def test_names_without_a_suffix_belong_to_no_action() -> None:
    assert action_of("Twist") == ()
    assert action_of("Goal") == ()
