from __future__ import annotations

import os

import pytest

from rostether.mechanisms.anonymous import anonymous_name
from rostether.names.graph_name import validate_name


def test_names_are_unique_and_legal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("socket.gethostname", lambda: "robot-1.local")
    names = {anonymous_name("arm") for _ in range(100)}
    assert len(names) == 100
    for name in names:
        assert name.startswith(f"arm_robot_1_local_{os.getpid()}_")
        assert validate_name(name) == name
