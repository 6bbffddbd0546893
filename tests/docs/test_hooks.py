"""Additions and removals by the build of the documentation."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest
from mkdocs.structure.files import File, Files

REPOSITORY = Path(__file__).parents[2]
HOOKS = runpy.run_path(str(REPOSITORY / "docs" / "hooks.py"))


def test_each_command_has_a_page(monkeypatch: pytest.MonkeyPatch) -> None:
    pages: dict[str, str] = {}

    def generated(_config: object, path: str, *, content: str) -> File:
        pages[path] = content
        return File(path, None, "site", use_directory_urls=True)

    monkeypatch.setattr(File, "generated", generated)
    HOOKS["on_files"](Files([]), None)
    assert "](topic.md)" in pages["reference/commands/index.md"]
    assert "## rostether topic echo" in pages["reference/commands/topic.md"]
    demo = pages["reference/commands/demo.md"]
    assert "`--port INTEGER RANGE`\n:   Start the ROS master on this port" in demo
    assert "&#91;1&#60;=x&#60;=65535&#93;" in demo
    assert "`-h, --help`" in demo
    assert "rostether demo --join" in demo


def test_marks_of_the_tests_are_removed() -> None:
    marked = '```sh title="On robot1" test="on robot1, and ended"\nls\n```\n'
    assert HOOKS["on_page_markdown"](marked) == '```sh title="On robot1"\nls\n```\n'
