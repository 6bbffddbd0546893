from __future__ import annotations

import pytest

from unit.cli.command_shell import Shell


@pytest.mark.parametrize("words", [(), ("3", "--all"), ("--groups", "1", "--all")])
def test_drive_needs_one_kind_of_target(shell: Shell, words: tuple[str, ...]) -> None:
    assert "give one of ROBOT, --groups or --all" in shell.failure("fleet", "drive", *words, code=2)
