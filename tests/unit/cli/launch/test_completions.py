from __future__ import annotations

from pathlib import Path

import click
import pytest

from rostether.cli.launch import completions

CONTEXT = click.Context(click.Command("run"))
PARAMETER = click.Argument(["package"])


def test_packages_and_their_programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    folder = tmp_path / "rosy_arm"
    folder.mkdir()
    (folder / "package.xml").write_text("<package><name>rosy_arm</name></package>")
    (folder / "move.py").write_text("#!/usr/bin/env python3\n")
    monkeypatch.chdir(tmp_path)
    assert completions.complete_package_folders(CONTEXT, PARAMETER, "rosy") == ["rosy_arm"]
    assert "rosserial_python" in completions.complete_package_folders(CONTEXT, PARAMETER, "ros")
    context = click.Context(click.Command("run"))
    context.params["package"] = "rosy_arm"
    assert completions.complete_programs(context, PARAMETER, "m") == ["move.py"]
    context.params["package"] = "topic_tools"
    assert completions.complete_programs(context, PARAMETER, "re") == ["relay"]
    context.params["package"] = "nothing"
    assert completions.complete_programs(context, PARAMETER, "") == []
