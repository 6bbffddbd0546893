from __future__ import annotations

from pathlib import Path

import pytest

from loop_watch import LoopWatch
from rostether.errors import UnknownTypeError
from rostether.msgdef.registry import Registry
from rostether.msgdef.search_waiting import definitions_searched, start_search, wait_for_definitions


@pytest.fixture
def registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Registry:
    """Packages on the path and around the current folder."""
    for place in ("path", "around"):
        (tmp_path / place / place / "msg").mkdir(parents=True)
        (tmp_path / place / place / "msg" / "Own.msg").write_text("uint8 x\n")
        (tmp_path / place / place / "package.xml").write_text(f"<package><name>{place}</name></package>")
    monkeypatch.chdir(tmp_path / "around")
    return Registry.from_environment(environ={"ROS_PACKAGE_PATH": str(tmp_path / "path")})


async def test_after_a_search_no_folder_is_searched(
    registry: Registry, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = LoopWatch(monkeypatch)
    await definitions_searched(registry)
    walked = watch.folders
    assert [registry.message(f"{each}/Own").full_name for each in ("path", "around")] == [
        "path/Own",
        "around/Own",
    ]
    with pytest.raises(UnknownTypeError):
        registry.message("nowhere/Own")
    await definitions_searched(registry)
    assert (watch.folders, watch.held) == (walked, 0)
    assert walked


async def test_one_search_serves_all(registry: Registry) -> None:
    assert start_search(registry) is start_search(registry)
    await wait_for_definitions(registry, lambda: registry.message("around/Own"))
    assert registry.can_answer(registry.packages)


async def test_a_failed_search_is_reported_to_the_waiting_caller(
    registry: Registry, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail() -> None:
        raise RecursionError

    monkeypatch.setattr(registry, "search", fail)
    with pytest.raises(RecursionError):
        await definitions_searched(registry)


async def test_bundled_types_need_no_search(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    watch = LoopWatch(monkeypatch)
    registry = Registry.from_environment(environ={})
    await wait_for_definitions(registry, lambda: registry.message("sensor_msgs/Imu"))
    assert registry.can_answer(lambda: registry.service("std_srvs/SetBool"))
    assert not registry.can_answer(lambda: registry.message("nowhere/Own"))
    assert (watch.folders, watch.held) == (0, 0)
