"""rclpy's exceptions as errors of this package."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rostether.errors import GraphError, InvalidNameError, RostetherError, TypeMismatchError

_Result = TypeVar("_Result")

# rclpy's exceptions for names derive from one of these two, depending on its version.
_NAME_ERRORS = frozenset({"NameValidationException", "InvalidTopicNameException"})


def attempt(what: str, function: Callable[[], _Result]) -> _Result:
    """Call a function of rclpy; `what` describes the call in errors, such as "subscribe to /chat".

    Raises InvalidNameError, TypeMismatchError or GraphError for rclpy's exceptions.
    """
    try:
        return function()
    except RostetherError:
        raise
    except Exception as error:
        reason = first_lines(str(error))
        if _NAME_ERRORS & {each.__name__ for each in type(error).__mro__}:
            raise InvalidNameError(f"cannot {what}: {reason}; ROS 2 does not allow this name") from error
        if "incompatible type" in reason:
            raise TypeMismatchError(f"cannot {what}: {reason}") from error
        raise GraphError(f"cannot {what}: {reason}") from error


def first_lines(text: str) -> str:
    """Return an error text of rclpy in one line, without the line of `^` marks."""
    lines = (line.strip() for line in text.splitlines())
    return " ".join(line for line in lines if line and set(line) != {"^"})
