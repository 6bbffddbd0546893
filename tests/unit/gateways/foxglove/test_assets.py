from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack
from pathlib import Path

import pytest

from loop_watch import LoopWatch
from rostether.errors import ConfigError
from rostether.gateways.foxglove import assets as assets_module
from rostether.gateways.foxglove.assets import Assets
from rostether.packages.locate import package_folders


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    package = tmp_path / "workspace/arm"
    (package / "meshes").mkdir(parents=True)
    (package / "meshes/left arm.stl").write_bytes(b"solid")
    (package / "package.xml").write_text("<package><name>arm</name></package>")
    (package / ".git").mkdir()
    (package / ".git/config").write_text("secret")
    (tmp_path / "workspace/secret").write_text("secret")
    (tmp_path / "workspace/arm_other").mkdir()
    (tmp_path / "workspace/arm_other/secret").write_text("secret")
    (package / "link").symlink_to(tmp_path / "workspace/secret")
    (package / "inner").symlink_to(package / "meshes")
    return package


async def read(assets: Assets, uri: str) -> bytes:
    async with assets.reading(uri) as data:
        return data


async def test_files_of_packages_are_read(folder: Path) -> None:
    assets = Assets(lambda: {"arm": folder}, 1000)
    for uri in (
        "package://arm/meshes/left%20arm.stl",
        "package://arm/meshes/../meshes/left arm.stl",
        "package://arm/inner/left arm.stl",
        f"file://{folder}/meshes/left%20arm.stl",
        f"file://localhost{folder}/meshes/left arm.stl",
    ):
        assert await read(assets, uri) == b"solid"


async def test_nothing_else_is(folder: Path) -> None:
    assets = Assets(lambda: {"arm": folder}, 1000)
    for uri in (
        "package://arm/../secret",
        "package://arm/%2e%2e/secret",
        "package://arm/..%2fsecret",
        "package://arm//etc/passwd",
        "package://arm/link",
        "package://arm/.git/config",
        "package://arm/meshes",
        "package://arm",
        "package://arm_other/secret",
        "package://../secret",
        "package:///etc/passwd",
        f"file://{folder.parent}/secret",
        f"file://{folder}/../secret",
        f"file://{folder}_other/secret",
        f"file://other.host{folder}/meshes/left%20arm.stl",
        "file:///etc/passwd",
        "http://localhost/secret",
        "package://arm/\0",
        "package://arm/" + "x" * 5000,
        "package://[",
        "",
    ):
        with pytest.raises(ConfigError) as caught:
            await read(assets, uri)
        assert "\n" not in str(caught.value)


async def test_a_file_that_is_too_large_is_not_sent(folder: Path) -> None:
    (folder / "large.stl").write_bytes(bytes(5000))
    with pytest.raises(ConfigError, match="larger than"):
        await read(Assets(lambda: {"arm": folder}, 1000), "package://arm/large.stl")


async def test_large_files_are_in_memory_for_a_few_clients_at_a_time(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(assets_module, "_LARGE_BYTES", 3)
    assets = Assets(lambda: {"arm": folder}, 1000)
    (folder / "small").write_bytes(b"abc")
    async with AsyncExitStack() as clients:
        for _ in range(assets_module._LARGE_AT_ONCE):
            await clients.enter_async_context(assets.reading("package://arm/meshes/left arm.stl"))
        another = asyncio.ensure_future(read(assets, "package://arm/meshes/left arm.stl"))
        assert await read(assets, "package://arm/small") == b"abc"
        assert not another.done()
    assert await another == b"solid"


async def test_a_package_that_comes_later_is_found(folder: Path) -> None:
    found: dict[str, Path] = {}
    assets = Assets(lambda: dict(found), 1000)
    with pytest.raises(ConfigError, match="ROS_PACKAGE_PATH"):
        await read(assets, "package://arm/meshes/left arm.stl")
    found["arm"] = folder
    assert await read(assets, "package://arm/meshes/left arm.stl") == b"solid"


async def test_a_workspace_whose_files_are_links_to_their_sources(folder: Path, tmp_path: Path) -> None:
    (folder / "package.xml").write_text("<package><name>arm</name></package>")
    share = tmp_path / "install/share/arm"
    share.mkdir(parents=True)
    for name in ("package.xml", "meshes", "link"):
        (share / name).symlink_to(folder / name)
    assets = Assets(lambda: {"arm": share}, 1000)
    assert await read(assets, "package://arm/meshes/left arm.stl") == b"solid"
    for name in ("link", ".git/config", "meshes/../../secret"):
        with pytest.raises(ConfigError):
            await read(assets, f"package://arm/{name}")


async def test_packages_are_searched_while_the_loop_continues(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = LoopWatch(monkeypatch)
    assets = Assets(lambda: package_folders({}, folder.parent), 1000)
    assert await read(assets, "package://arm/meshes/left%20arm.stl") == b"solid"
    assert await read(assets, f"file://{folder}/meshes/left%20arm.stl") == b"solid"
    assert watch.folders
    assert watch.held == 0
