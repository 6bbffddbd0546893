from __future__ import annotations

import pytest

from rostether.cli.shell.failures import EXIT_FAILED, EXIT_INTERRUPTED, exit_code_of
from unit.cli.command_shell import Shell


def test_an_error_that_ctrl_c_caused_is_an_interruption(capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted_in_a_class_body() -> None:
        raise RuntimeError("Error calling __set_name__") from KeyboardInterrupt()

    assert exit_code_of(interrupted_in_a_class_body) == EXIT_INTERRUPTED
    assert capsys.readouterr().err == ""


def test_other_errors_are_reported(capsys: pytest.CaptureFixture[str]) -> None:
    def failing() -> None:
        raise RuntimeError("broken") from ValueError("below")

    assert exit_code_of(failing) == EXIT_FAILED
    assert "RuntimeError: broken" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("given", "line"),
    [
        ("--hosts", "No such option '--hosts'; did you mean --host or --ros2 or --show-types?"),
        ("--jsn", "No such option '--jsn'; did you mean --json?"),
        ("--qqq", "No such option '--qqq'; see `rostether topic list --help`"),
    ],
)
def test_similar_options_are_suggested(shell: Shell, given: str, line: str) -> None:
    assert shell.failure("topic", "list", given, code=2) == line
