"""What errors have in common."""

from __future__ import annotations

from rostether.errors import ConfigError, first_error


def test_the_first_error_of_nested_groups_is_found() -> None:
    wrong, other = ConfigError("wrong"), ValueError("other")
    assert first_error(BaseExceptionGroup("outer", [ExceptionGroup("inner", [wrong, other]), other])) is wrong
    assert first_error(other) is other
