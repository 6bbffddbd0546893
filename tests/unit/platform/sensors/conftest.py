from __future__ import annotations

import pytest

from rostether.platform import sensing_manager
from rostether.platform.sensors import camera, readings, registered_sensor


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sensing_manager, "STATE_PERIOD_S", 0.01)
    monkeypatch.setattr(sensing_manager, "GATHER_S", 0.001)
    monkeypatch.setattr(registered_sensor, "RENEWAL_S", 0.1)
    monkeypatch.setattr(registered_sensor, "RETRY_S", 0.02)
    monkeypatch.setattr(registered_sensor, "_SHORTEST_PERIOD_S", 0.01)
    monkeypatch.setattr(readings, "RETRY_S", 0.02)
    monkeypatch.setattr(camera, "_POLL_S", 0.01)
