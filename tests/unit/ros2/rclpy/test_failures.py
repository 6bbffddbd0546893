"""Exceptions of rclpy as errors of this package."""

from __future__ import annotations

from typing import NoReturn

import pytest

from rostether.errors import GraphError, InvalidNameError, RostetherError, TypeMismatchError, UnknownTypeError
from rostether.ros2.rclpy.failures import attempt


class InvalidNodeNameException(Exception):
    """Has the name of an exception of rclpy."""


class NameValidationException(Exception):
    """Has the name of an exception of rclpy."""


class InvalidTopicNameException(NameValidationException):
    """Has the name of an exception of rclpy."""


@pytest.mark.parametrize(
    ("raised", "error", "text"),
    [
        (
            InvalidTopicNameException("Invalid topic name: must not end:\n  '/a/'\n      ^"),
            InvalidNameError,
            "cannot publish /a/: Invalid topic name: must not end: '/a/'; ROS 2 does not allow this name",
        ),
        (
            RuntimeError("create_publisher() called for existing topic name rt/a with incompatible type X"),
            TypeMismatchError,
            "with incompatible type X",
        ),
        (RuntimeError("no more\nmemory"), GraphError, "cannot publish /a/: no more memory"),
        (UnknownTypeError("no such type"), UnknownTypeError, "no such type"),
    ],
)
def test_exceptions_become_errors_of_this_package(
    raised: Exception, error: type[RostetherError], text: str
) -> None:
    def fail() -> NoReturn:
        raise raised

    with pytest.raises(error) as caught:
        attempt("publish /a/", fail)
    assert text in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_result_is_returned() -> None:
    assert attempt("add", lambda: 2) == 2
