from __future__ import annotations

import asyncio
import ctypes
import gc
import weakref
from collections.abc import Iterator

import pytest

from rostether.bridge import process_memory
from rostether.bridge.process_memory import FEW_BOARDS, BoardObjects, release_memory
from unit.bridge.line_boards import Bridge, TcpBoard
from waiting import until


class _Circle:
    """Garbage that only the collector can free."""

    def __init__(self) -> None:
        self.itself = self


@pytest.fixture
def _soon(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(process_memory, "FREEZE_AFTER_S", 0.0)
    monkeypatch.setattr(process_memory, "COLLECT_PERIOD_S", 0.0)
    gc.unfreeze()
    yield
    gc.unfreeze()


async def _turns() -> None:
    for _ in range(3):
        await asyncio.sleep(0)


@pytest.mark.usefixtures("_soon")
async def test_the_collector_inspects_objects_of_many_boards_no_more() -> None:
    objects = BoardObjects()
    for _ in range(FEW_BOARDS):
        objects.connected()
    await _turns()
    assert gc.get_freeze_count() == 0
    objects.connected()
    await _turns()
    assert gc.get_freeze_count() > 1000
    objects.close()
    assert gc.get_freeze_count() == 0


@pytest.mark.usefixtures("_soon")
async def test_the_garbage_of_many_boards_is_collected() -> None:
    objects = BoardObjects()
    for _ in range(4 * FEW_BOARDS):
        objects.connected()
    circle = _Circle()
    alive = weakref.ref(circle)
    await _turns()
    del circle
    gc.collect()
    for _ in range(FEW_BOARDS):
        objects.disconnected()
    await _turns()
    assert alive() is not None
    objects.disconnected()
    await _turns()
    assert alive() is None
    objects.close()


@pytest.mark.usefixtures("_soon")
async def test_a_board_that_reconnects_leaves_no_garbage() -> None:
    objects = BoardObjects()
    alive = []
    for _ in range(2 * FEW_BOARDS):
        objects.connected()
        circle = _Circle()
        alive.append(weakref.ref(circle))
        gc.freeze()
        del circle
        objects.disconnected()
        await _turns()
    assert sum(each() is not None for each in alive) <= FEW_BOARDS
    objects.close()


async def _leave(objects: BoardObjects) -> None:
    for _ in range(FEW_BOARDS + 1):
        objects.connected()
        objects.disconnected()
    await _turns()


@pytest.mark.usefixtures("_soon")
async def test_after_many_boards_have_left_the_collector_still_ignores_the_program() -> None:
    objects = BoardObjects()
    gc.freeze()
    await _leave(objects)
    assert gc.get_freeze_count() > 1000
    objects.close()


@pytest.mark.usefixtures("_soon")
async def test_boards_that_connect_and_leave_all_the_time_cause_few_collections(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    collections: list[int] = []
    monkeypatch.setattr(gc, "collect", lambda: collections.append(1))
    monkeypatch.setattr(process_memory, "COLLECT_PERIOD_S", 60.0)
    objects = BoardObjects()
    for _ in range(3):
        await _leave(objects)
        objects.node_left()
    assert len(collections) == 1
    objects.close()


@pytest.mark.usefixtures("_soon")
async def test_a_supervisor_counts_its_boards() -> None:
    async with Bridge() as bridge:
        boards = [TcpBoard(bridge.port) for _ in range(FEW_BOARDS + 1)]
        for board in boards:
            await board.connect()
        await until(lambda: gc.get_freeze_count() > 0, "the freeze")
        for board in boards:
            await board.hang_up()
    assert gc.get_freeze_count() == 0


@pytest.mark.usefixtures("_soon")
async def test_the_garbage_of_nodes_is_collected_and_released_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    released: list[int] = []
    monkeypatch.setattr(process_memory, "RELEASE_AFTER_S", 0.0)
    monkeypatch.setattr(process_memory, "release_memory", lambda: released.append(1))
    objects = BoardObjects()
    circles = [_Circle() for _ in range(2 * FEW_BOARDS)]
    alive = [weakref.ref(circle) for circle in circles]
    for _ in circles:
        objects.connected()
    await _turns()
    # The boards leave first, their nodes after the grace period.
    for _ in circles:
        objects.disconnected()
    await _turns()
    circles.clear()
    for _ in alive:
        objects.node_left()
    await until(lambda: released, "the release")
    assert not any(each() is not None for each in alive)
    assert released == [1]
    objects.close()


def test_memory_is_given_back() -> None:
    release_memory()


def test_another_c_library_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ctypes, "CDLL", lambda _: object())
    release_memory()
