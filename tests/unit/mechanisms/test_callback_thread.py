from __future__ import annotations

import threading
from collections.abc import Callable

import pytest

from rostether.mechanisms import callback_thread
from rostether.mechanisms.callback_thread import HIGH_WATER_ITEMS, LOW_WATER_ITEMS, CallbackThread


def wait_until(condition: Callable[[], bool]) -> None:
    """Wait until a condition holds."""
    done = threading.Event()
    for _ in range(12_000):
        if condition():
            return
        done.wait(0.005)
    raise AssertionError("never")


def test_items_run_in_order_in_another_thread() -> None:
    seen: list[tuple[int, int]] = []
    thread: CallbackThread[int] = CallbackThread("t", lambda item: seen.append((item, threading.get_ident())))
    thread.put(range(100))
    wait_until(lambda: len(seen) == 100)
    assert [item for item, _ in seen] == list(range(100))
    assert {ident for _, ident in seen} - {threading.get_ident()}
    thread.close()


def test_a_limit_keeps_the_newest() -> None:
    gate, seen = threading.Event(), list[int]()

    def run(item: int) -> None:
        gate.wait()
        seen.append(item)

    thread = CallbackThread("t", run, limit=2)
    thread.put([0])
    wait_until(lambda: not thread._items)
    thread.put(range(1, 50))
    gate.set()
    wait_until(lambda: len(seen) == 3)
    assert seen == [0, 48, 49]
    thread.close()


def test_the_source_is_asked_to_stop_and_to_continue() -> None:
    gate, reported, seen = threading.Event(), list[bool](), list[int]()

    def run(item: int) -> None:
        gate.wait()
        seen.append(item)

    thread = CallbackThread("t", run, on_full=reported.append)
    thread.put(range(HIGH_WATER_ITEMS + 2))
    assert reported == [True]
    gate.set()
    wait_until(lambda: len(seen) == HIGH_WATER_ITEMS + 2)
    assert reported == [True, False]
    assert LOW_WATER_ITEMS < HIGH_WATER_ITEMS
    thread.close()


def test_an_idle_thread_ends_and_a_new_one_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(callback_thread, "IDLE_S", 0.01)
    seen: list[int] = []
    thread = CallbackThread("t", seen.append)
    thread.put([1])
    wait_until(lambda: seen == [1] and not thread.is_alive)
    thread.put([2])
    wait_until(lambda: seen == [1, 2])
    thread.close()


def test_nothing_runs_after_the_end() -> None:
    seen: list[int] = []
    thread = CallbackThread("t", seen.append)
    thread.close()
    thread.put([1])
    assert seen == []
    assert not thread.is_alive
