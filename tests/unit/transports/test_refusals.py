from __future__ import annotations

import pytest

from rostether.transports.refusals import RefusalLog


def test_a_scan_does_not_fill_the_log(caplog: pytest.LogCaptureFixture) -> None:
    now_s = 0.0
    refusals = RefusalLog("tcp://:1", lambda: now_s)
    for _ in range(100):
        refusals.refuse("tcp 10.0.0.9:5", "it is full")
        now_s += 0.05
    assert [record.getMessage() for record in caplog.records] == [
        "tcp://:1 refused tcp 10.0.0.9:5: it is full"
    ]
    now_s = 10.0
    refusals.refuse("tcp 10.0.0.8:5", "it is full")
    assert caplog.records[-1].getMessage().endswith("it is full (99 more since the last such line)")
    assert len(caplog.records) == 2
    assert refusals.count == 101
