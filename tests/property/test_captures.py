"""A capture with any content is read, or refused in one line."""

from __future__ import annotations

import json
from pathlib import Path
from tempfile import TemporaryDirectory

from hypothesis import given
from hypothesis import strategies as st

from rostether.errors import ConfigError
from rostether.rosserial.line_log import LineLog, version_of
from rostether.transports.capture import Capture, Chunk

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=4,
)
LINES = st.fixed_dictionaries(
    {},
    optional={
        "t": VALUES | st.floats(0, 10),
        "from": VALUES | st.sampled_from(["device", "host"]),
        "hex": VALUES | st.binary(max_size=40).map(bytes.hex),
        "event": VALUES | st.sampled_from(["opened", "closed"]),
        "link": VALUES | st.integers(1, 3),
        "peer": VALUES,
    },
)


def read_or_refuse(content: bytes) -> None:
    """Read a capture; an error has one line with the position."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "any.jsonl"
        path.write_bytes(content)
        last_s = 0.0
        try:
            for entry in Capture(path).entries():
                assert last_s <= entry.time_s
                last_s = entry.time_s
        except ConfigError as error:
            assert str(error).startswith((f"{path}, line ", f"{path} is empty"))
            assert len(str(error).splitlines()) == 1


@given(st.binary(max_size=300))
def test_a_capture_of_any_bytes_is_read_or_refused(content: bytes) -> None:
    read_or_refuse(content)


@given(st.lists(LINES, max_size=6))
def test_a_capture_of_any_lines_is_read_or_refused(lines: list[dict[str, object]]) -> None:
    read_or_refuse("\n".join(json.dumps(line) for line in [{"capture": "x"}, *lines]).encode())


@given(st.lists(st.tuples(st.floats(0, 1), st.booleans(), st.binary(max_size=60)), max_size=10))
def test_log_entries_are_printable(chunks: list[tuple[float, bool, bytes]]) -> None:
    log = LineLog(version_of(b"".join(data for _, _, data in chunks)))
    time_s = 0.0
    for step_s, from_device, data in chunks:
        time_s += step_s
        chunk = Chunk(time_s, 1, from_device, data)
        for entry in log.feed(chunk.time_s, chunk.from_device, chunk.data):
            assert entry.what.isprintable()
    for entry in log.finish(time_s):
        assert entry.what.isprintable()
