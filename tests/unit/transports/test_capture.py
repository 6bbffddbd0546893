from __future__ import annotations

import json
from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.transports.capture import MAX_LINE_BYTES, Capture, Chunk, LinkClosed, LinkOpened
from vectors.captures import load, names

VECTORS = Path(__file__).parents[2] / "vectors"
FIRST = '{"capture": "arm"}\n'


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "arm.jsonl"
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", names())
def test_the_recorded_sessions_are_captures(name: str) -> None:
    expected = load(name)
    capture = Capture(VECTORS / f"{name}.jsonl")
    chunks = [each for each in capture.entries() if isinstance(each, Chunk)]
    assert [(each.from_device, each.data) for each in chunks] == [
        (each.from_device, each.data) for each in expected.chunks
    ]
    times_s = [each.time_s for each in chunks]
    assert times_s == sorted(times_s)
    assert capture.version == (1 if expected.version == 1 else None)


def test_links_and_events(tmp_path: Path) -> None:
    lines = [
        {"t": 0.5, "event": "opened", "peer": "tcp 127.0.0.1:5", "link": 2},
        {"t": 1, "from": "host", "hex": "FFfe", "link": 2, "clean": "ff"},
        {"t": 1, "event": "somebody sneezed"},
        {"t": 0.7, "from": "device", "hex": ""},
        {"t": 2, "event": "closed", "link": 2},
    ]
    text = FIRST + "\n" + "\n".join(json.dumps(line) for line in lines)
    assert list(Capture(written(tmp_path, text)).entries()) == [
        LinkOpened(0.5, 2, "tcp 127.0.0.1:5"),
        Chunk(1.0, 2, False, b"\xff\xfe"),
        Chunk(1.0, 1, True, b""),
        LinkClosed(2.0, 2),
    ]


def test_a_recorder_that_was_killed_leaves_a_capture(tmp_path: Path) -> None:
    text = FIRST + '{"t": 1, "from": "device", "hex": "00"}\n{"t": 2, "from": "dev'
    assert list(Capture(written(tmp_path, text)).entries()) == [Chunk(1.0, 1, True, b"\0")]


@pytest.mark.parametrize(
    ("line", "reported"),
    [
        ("nonsense", "JSON is malformed"),
        ("[1]", "expected object, got array"),
        ("[" * 100_000, "expected object, got array"),
        # Python 3.14 limits the bytes of the stack, not the depth.
        ('{"t": 1, "x": ' + "[" * 1_000_000, "nested too deeply"),
        ('{"from": "device", "hex": "00"}', "missing required field t"),
        ('{"t": "1", "from": "device", "hex": "00"}', "t: expected number, got string"),
        ('{"t": NaN, "from": "device", "hex": "00"}', "JSON is malformed"),
        ('{"t": 1e300, "from": "device", "hex": "00"}', "t: expected number <= 100000000.0"),
        ('{"t": 1' + "0" * 4000 + ', "from": "device", "hex": "00"}', "t: number out of range"),
        ('{"t": -1, "from": "device", "hex": "00"}', "t: expected number >= 0.0"),
        ('{"t": 1, "from": "moon", "hex": "00"}', "from: invalid enum value 'moon'"),
        ('{"t": 1, "from": "device", "hex": "0"}', "`hex` is not hexadecimal"),
        ('{"t": 1, "from": "device", "hex": 7}', "hex: expected string or null, got integer"),
        ('{"t": 1, "from": "device"}', "`from` and `hex`"),
        ('{"t": 1, "from": "device", "hex": "00", "link": 0}', "link: expected integer >= 1"),
        ('{"t": 1, "from": "device", "hex": "00", "link": "b"}', "link: expected integer, got string"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, line: str, reported: str) -> None:
    path = written(tmp_path, f'{FIRST}{{"t": 0, "from": "host", "hex": "00"}}\n{line}\n')
    with pytest.raises(ConfigError) as caught:
        list(Capture(path).entries())
    assert f"{path}, line 3: " in str(caught.value)
    assert reported in str(caught.value)
    assert "\n" not in str(caught.value)


def test_bytes_that_are_not_text(tmp_path: Path) -> None:
    path = tmp_path / "board.bin"
    path.write_bytes(bytes(range(256)) * 100)
    with pytest.raises(ConfigError, match="line 1: JSON is malformed"):
        Capture(path)


def test_a_line_that_never_ends(tmp_path: Path) -> None:
    path = written(tmp_path, FIRST + " " * (MAX_LINE_BYTES + 1))
    with pytest.raises(ConfigError, match="line 2: longer than 4 MiB"):
        list(Capture(path).entries())


@pytest.mark.parametrize("first", ['{"t": 1, "from": "device", "hex": "00"}', "{}"])
def test_a_file_without_a_description(tmp_path: Path, first: str) -> None:
    with pytest.raises(ConfigError, match="line 1: no header"):
        Capture(written(tmp_path, first + "\n"))


def test_an_empty_file_and_none(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="is empty"):
        Capture(written(tmp_path, ""))
    with pytest.raises(ConfigError, match="No such file"):
        Capture(tmp_path / "none.jsonl")
