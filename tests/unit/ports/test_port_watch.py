from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rostether.ports import port_watch
from rostether.ports.port_watch import PortWatch
from rostether.transports.serial_port import SerialPort


class System:
    """A system whose ports are files in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.seen: list[list[str]] = []
        self.list_count = 0

    def ports(self) -> list[SerialPort]:
        self.list_count += 1
        return [SerialPort(str(path), "") for path in sorted(self.folder.glob("tty*"))]

    async def follow(self, watch: PortWatch) -> None:
        async for ports in watch.changes():
            self.seen.append([Path(port.path).name for port in ports])

    async def until_seen(self, *names: str) -> None:
        async with asyncio.timeout(60):
            while not self.seen or self.seen[-1] != list(names):
                await asyncio.sleep(0.002)


async def until_quiet(count: Callable[[], int]) -> None:
    """Wait until a count is above 0 and has not changed for 0.3 s."""
    async with asyncio.timeout(60):
        before = 0
        while not before or count() != before:
            before = count()
            await asyncio.sleep(0.3)


def notifications() -> int:
    """Return the number of this process's descriptors for notifications of the kernel."""
    count = 0
    for each in Path("/proc/self/fd").glob("*"):
        with contextlib.suppress(FileNotFoundError):
            count += "inotify" in str(each.readlink())
    return count


def no_events(_folders: object) -> None:
    raise OSError("no inotify here")


@pytest.fixture(params=["woken by the kernel", "by looking"])
def either_way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param == "by looking":
        monkeypatch.setattr(port_watch, "FolderEvents", no_events)
    elif sys.platform != "linux":
        pytest.skip("inotify exists only on Linux")


@pytest.mark.usefixtures("either_way")
async def test_ports_appear_and_disappear(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(port_watch, "SETTLING_S", 0.05)
    system = System(tmp_path)
    watch = PortWatch(system.ports, folders=[str(tmp_path)], period_s=0.005)
    following = asyncio.ensure_future(system.follow(watch))
    await system.until_seen()
    for _ in range(3):
        (tmp_path / "ttyACM0").touch()
        await system.until_seen("ttyACM0")
        (tmp_path / "ttyACM1").touch()
        await system.until_seen("ttyACM0", "ttyACM1")
        await asyncio.sleep(0.1)
        (tmp_path / "ttyACM0").unlink()
        await system.until_seen("ttyACM1")
        (tmp_path / "ttyACM1").unlink()
        await system.until_seen()
    following.cancel()


@pytest.mark.usefixtures("either_way")
async def test_a_folder_that_is_created_later_is_watched_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(port_watch, "SETTLING_S", 0.02)
    folder = tmp_path / "sim"
    system = System(folder)
    watch = PortWatch(system.ports, folders=[str(tmp_path), str(folder)], period_s=0.005)
    following = asyncio.ensure_future(system.follow(watch))
    await system.until_seen()
    for _ in range(2):
        folder.mkdir()
        await asyncio.sleep(0.1)
        (folder / "ttySIM").touch()
        await system.until_seen("ttySIM")
        shutil.rmtree(folder)
        await system.until_seen()
    following.cancel()


@pytest.mark.usefixtures("either_way")
async def test_ports_are_not_listed_without_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(port_watch, "SETTLING_S", 0.02)
    system = System(tmp_path)
    watch = PortWatch(system.ports, folders=[str(tmp_path)], period_s=0.001)
    following = asyncio.ensure_future(system.follow(watch))
    await until_quiet(lambda: system.list_count)
    following.cancel()


@pytest.mark.skipif(sys.platform != "linux", reason="inotify exists only on Linux")
async def test_no_polling_with_kernel_notifications(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(port_watch, "SETTLING_S", 0.02)
    looks = 0
    mark = port_watch.folder_mark

    def counted(folder: str) -> int:
        nonlocal looks
        looks += 1
        return mark(folder)

    monkeypatch.setattr(port_watch, "folder_mark", counted)
    system = System(tmp_path)
    watch = PortWatch(system.ports, folders=[str(tmp_path)], period_s=0.001)
    following = asyncio.ensure_future(system.follow(watch))
    await until_quiet(lambda: looks)
    (tmp_path / "ttyACM0").touch()
    await system.until_seen("ttyACM0")
    following.cancel()


async def test_many_new_files_cause_few_lists(tmp_path: Path) -> None:
    system = System(tmp_path)
    period_s, clock = 0.05, asyncio.get_running_loop().time
    watch = PortWatch(system.ports, folders=[str(tmp_path)], period_s=period_s)
    began_s = clock()
    following = asyncio.ensure_future(system.follow(watch))
    await system.until_seen()
    for number in range(300):
        (tmp_path / f"loop{number}").touch()
        await asyncio.sleep(0.001)
    # At most one list in each period, even if a busy machine needs long for the files.
    assert system.list_count <= (clock() - began_s) / period_s + 1
    following.cancel()


async def test_descriptors_are_released(tmp_path: Path) -> None:
    system = System(tmp_path)
    before = notifications()
    for _ in range(5):
        following = asyncio.ensure_future(
            system.follow(PortWatch(system.ports, folders=[str(tmp_path)], period_s=0.001))
        )
        await asyncio.sleep(0.01)
        following.cancel()
        await asyncio.gather(following, return_exceptions=True)
    assert notifications() == before


async def test_late_serial_numbers_are_detected(tmp_path: Path) -> None:
    """udev adds a serial number shortly after the port has appeared."""
    numbers = [None, None, "7533"]
    seen: list[str | None] = []

    def list_ports() -> list[SerialPort]:
        return [
            SerialPort("/dev/ttyACM0", "Uno", serial_number=numbers.pop(0) if len(numbers) > 1 else "7533")
        ]

    async with asyncio.timeout(60):
        async for ports in PortWatch(list_ports, folders=[str(tmp_path)], period_s=0.001).changes():
            seen.append(ports[0].serial_number)
            if len(seen) == 2:
                break
    assert seen == [None, "7533"]


async def test_where_ports_are_not_files_the_list_is_requested(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(port_watch, "SETTLING_S", 0.0)
    monkeypatch.setattr(port_watch, "BLIND_LIST_PERIOD_S", 0.01)
    names = ["COM3"]
    seen = []
    watch = PortWatch(
        lambda: [SerialPort(name, "") for name in names], folders=[str(tmp_path / "none")], period_s=0.001
    )
    async with asyncio.timeout(60):
        async for ports in watch.changes():
            seen.append([port.path for port in ports])
            names.append("COM4")
            if len(seen) == 2:
                break
    assert seen[0] == ["COM3"]
    assert seen[1][:2] == ["COM3", "COM4"]


def test_ports_that_the_user_names_are_listed_in_any_folder(tmp_path: Path) -> None:
    near, far = os.openpty()
    try:
        link = tmp_path / "ttySIM"
        link.symlink_to(os.ttyname(far))
        (tmp_path / "ttyFILE").touch()
        entries = (f"{tmp_path}/tty*", str(tmp_path / "none"), "2341:0043", "all")
        watch = PortWatch(list, entries=entries, folders=[])
        assert [port.path for port in watch.list()] == [str(link)]
        known = SerialPort(os.ttyname(far), "listed by the system")
        assert PortWatch(lambda: [known], entries=entries, folders=[]).list() == [known]
    finally:
        os.close(near)
        os.close(far)


def test_a_check_is_cheap() -> None:
    began = time.process_time()
    for _ in range(1000):
        port_watch.folder_mark("/")
    # Four checks a second: 0.1 % of a CPU is 0.25 ms for each.
    assert (time.process_time() - began) / 1000 < 0.000_25
