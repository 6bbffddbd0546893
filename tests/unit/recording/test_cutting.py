from __future__ import annotations

import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

import pytest

from rostether.errors import ConfigError, RecordingError
from rostether.recording.cutting import Cutting, find_recordings, moment_ns, second_moment
from rostether.recording.files import open_recording
from rostether.rostime import NS_PER_S
from unit.recording.bags import START_NS, write_bag


@pytest.fixture(autouse=True)
def _berlin(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("TZ", "Europe/Berlin")
    time.tzset()
    yield
    monkeypatch.undo()
    time.tzset()


def shown(text: str, last: str) -> str:
    last_ns = int(datetime.fromisoformat(last).timestamp()) * NS_PER_S
    return datetime.fromtimestamp(moment_ns(text, last_ns) / NS_PER_S).isoformat(" ")


@pytest.mark.parametrize(
    ("text", "moment"),
    [
        ("14:02", "2026-11-23 14:02:00"),
        ("9:30:05.25", "2026-11-23 09:30:05.250000"),
        # Later than the last message: the day before.
        ("16:00", "2026-11-22 16:00:00"),
        ("2026-11-20 16:00", "2026-11-20 16:00:00"),
        ("2026-06-20T16:00:30", "2026-06-20 16:00:30"),
        ("9:30Z", "2026-11-23 10:30:00"),
        ("14:30Z", "2026-11-22 15:30:00"),
        ("2026-06-20 16:00+0000", "2026-06-20 18:00:00"),
    ],
)
def test_times_are_local(text: str, moment: str) -> None:
    assert shown(text, "2026-11-23 15:00:00") == moment


def test_a_local_time_that_occurs_twice() -> None:
    first_ns = moment_ns("2026-10-25 02:30", START_NS)
    second = second_moment("2026-10-25 02:30", first_ns)
    assert second == "2026-10-25 02:30:00+01:00"
    assert moment_ns(second, START_NS) == first_ns + 3600 * NS_PER_S
    assert not second_moment("2026-10-25 02:30+02:00", first_ns)
    assert not second_moment("2026-10-25 03:30", first_ns + 2 * 3600 * NS_PER_S)


@pytest.mark.parametrize("text", ["", "14", "25:00", "yesterday", "2026-13-01 10:00"])
def test_invalid_times_are_refused(text: str) -> None:
    with pytest.raises(ConfigError, match="is not a time; write 14:02"):
        moment_ns(text, START_NS)


def test_a_span_of_several_recordings_is_cut(tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    folder.mkdir()
    # 30 messages each, 10 ms apart, on /a and /b; the second file is being recorded.
    written = write_bag(folder / "R3_0.bag")
    write_bag(folder / "R3_1.bag.active", closes=False)
    (folder / "notes.txt").write_text("none")
    (folder / "R3_2.bag").write_text("damaged")
    # A folder for each robot.
    assert find_recordings([tmp_path]) == find_recordings([folder])
    cutting = Cutting(find_recordings([folder]))
    assert list(cutting.unreadable) == [folder / "R3_2.bag"]
    assert cutting.span_ns == (written[0][1], written[-1][1])
    start_ns, end_ns = written[10][1], written[13][1]
    target = tmp_path / "seen.bag"
    assert cutting.write(target, lambda each: each.topic == "/a", start_ns, end_ns) == (4, 2)
    reader = open_recording(target)
    found = [(each.connection.topic, each.time_ns, each.payload) for each in reader.messages()]
    reader.close()
    assert found == [written[place] for place in (10, 10, 12, 12)]
    # An existing file is kept if there are no messages.
    assert cutting.write(target, lambda _: True, end_ns + NS_PER_S, end_ns + 2 * NS_PER_S) == (0, 0)
    assert cutting.write(target, lambda each: each.topic == "/c", start_ns, end_ns) == (0, 0)
    assert target.exists()
    with pytest.raises(RecordingError, match="is the input file"):
        cutting.write(folder / "R3_0.bag", lambda _: True, start_ns, end_ns)


def test_missing_recordings_are_reported(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no recordings in"):
        find_recordings([tmp_path])
    with pytest.raises(RecordingError, match="No such file"):
        Cutting(find_recordings([tmp_path / "none.bag"]))
