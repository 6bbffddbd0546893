from __future__ import annotations

import ctypes

import pytest

from rostether.bridge.free_memory import give_back_memory


def test_memory_is_given_back() -> None:
    give_back_memory()


def test_another_c_library_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ctypes, "CDLL", lambda _: object())
    give_back_memory()
