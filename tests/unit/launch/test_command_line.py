from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.launch.command_line import log_folder, ros_home


def test_log_folder_of_a_run_and_the_link_to_the_latest(tmp_path: Path) -> None:
    environ = {"ROS_HOME": str(tmp_path)}
    for run_id in ("first", "second"):
        assert log_folder(environ, run_id) == tmp_path / "log" / run_id
        assert (tmp_path / "log" / "latest").resolve() == tmp_path / "log" / run_id


def test_log_folder_of_the_environment_has_priority(tmp_path: Path) -> None:
    environ = {"ROS_HOME": "/does/not/exist", "ROS_LOG_DIR": str(tmp_path)}
    assert log_folder(environ, "run") == tmp_path / "run"


def test_a_folder_with_the_name_latest_is_kept(tmp_path: Path) -> None:
    (tmp_path / "latest").mkdir()
    log_folder({"ROS_LOG_DIR": str(tmp_path)}, "run")
    assert not (tmp_path / "latest").is_symlink()


def test_folder_that_cannot_be_created_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match="ROS_LOG_DIR"):
        log_folder({"ROS_LOG_DIR": str(tmp_path / "file")}, "run")


def test_home_is_dot_ros_by_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/x")
    assert ros_home({}) == Path("/home/x/.ros")
