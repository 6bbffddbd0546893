"""`rostether bag`, as its users type it."""

from __future__ import annotations

import json
import os
import pty
import re
import select
import signal
import subprocess
import termios
from datetime import datetime
from pathlib import Path

import pytest
import yaml
from mcap.writer import Writer

from programs import ROSTETHER
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.recording.bag.reader import BagReader
from rostether.rostime import NS_PER_S
from unit.cli.command_shell import LiveGraph, Shell
from unit.recording.bags import START_NS, STRING, text, write_bag
from waiting import until


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    path = tmp_path / "a.bag"
    write_bag(path)
    return path


def _started(graph: LiveGraph, *arguments: str, stdin: int = subprocess.DEVNULL) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [*ROSTETHER, "bag", *arguments],
        env={**os.environ, "ROS_MASTER_URI": graph.uri},
        stdin=stdin,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_info_in_its_forms(bag: Path, shell: Shell) -> None:
    printed = shell.output("bag", "info", str(bag))
    assert "messages:    30\n" in printed
    assert "topics:      /a   15 msgs    : std_msgs/String\n" in printed
    facts = json.loads(shell.output("bag", "info", "--json", str(bag)))
    assert (facts["messages"], facts["duration_s"], facts["indexed"]) == (30, 0.29, True)
    assert facts["topics"][1] == {"topic": "/b", "type": "std_msgs/String", "messages": 15, "connections": 1}
    assert yaml.safe_load(shell.output("bag", "info", "-y", str(bag)))["messages"] == 30
    assert shell.output("bag", "info", "-y", "-k", "messages", str(bag)) == "30\n"
    assert "15 msgs @ 50.0 Hz : std_msgs/String" in shell.output("bag", "info", "--freq", str(bag))
    assert "there is no key 'color'" in shell.failure("bag", "info", "-y", "-k", "color", str(bag))


def test_info_names_a_topic_that_cannot_be_read(tmp_path: Path, shell: Shell) -> None:
    path = tmp_path / "own.mcap"
    writer = Writer(str(path))
    writer.start(profile="ros2")
    schema = writer.register_schema("own_msgs/msg/Own", "ros2msg", b"int32[< a\n")
    channel = writer.register_channel("/own", "cdr", schema)
    writer.add_message(channel, START_NS, b"\0\1\0\0", START_NS)
    writer.finish()  # type: ignore[no-untyped-call]
    result = shell("bag", "info", str(path))
    assert result.code == 0
    assert "own.mcap: /own is not shown: " in result.err


def test_filter_by_topic_message_and_time(bag: Path, tmp_path: Path, shell: Shell) -> None:
    target = tmp_path / "b.bag"

    def kept(expression: str) -> list[bytes]:
        shell.output("bag", "filter", str(bag), str(target), expression)
        return [message.payload for message in BagReader(target).messages()]

    assert kept("topic == '/b'") == [text(f"message {index}") for index in range(1, 30, 2)]
    assert kept("m.data == 'message 7'") == [text("message 7")]
    assert kept("t.nsecs < 130000000 and topic == '/a'") == [text("message 0")]
    assert "/a: EXPRESSION: there is no .nothing; the fields are" in shell.failure(
        "bag", "filter", str(bag), str(target), "topic == '/b' or m.nothing"
    )
    assert "is not an expression (write == to compare)" in shell.failure(
        "bag", "filter", str(bag), str(target), "topic = '/b'"
    )
    assert "is not an expression (invalid syntax)" in shell.failure(
        "bag", "filter", str(bag), str(target), "m.data >"
    )
    assert "is the input file; give" in shell.failure("bag", "filter", str(bag), str(bag), "True")


def test_check_names_what_does_not_fit(tmp_path: Path, bag: Path, shell: Shell) -> None:
    assert "30 messages, no errors" in shell.output("bag", "check", str(bag))
    data = bag.read_bytes()
    bag.write_bytes(data.replace(text("message 7"), b"\xff" + text("message 7")[1:]))
    result = shell("bag", "check", str(bag))
    assert result.code == 1
    assert "/b: 1 message does not fit its type" in result.out
    bag.write_bytes(data[:5000])
    assert "bag reindex" in shell("bag", "check", str(bag)).out


def test_reindex_and_convert(tmp_path: Path, bag: Path, shell: Shell) -> None:
    active = tmp_path / "b.bag.active"
    active.write_bytes(bag.read_bytes()[:-100])
    assert "30 messages kept" in shell.output("bag", "reindex", str(active))
    assert not active.exists()
    assert (tmp_path / "b.orig.bag").exists()
    mended, mcap = tmp_path / "b.bag", tmp_path / "b.mcap"
    assert "complete, not changed" in shell.output("bag", "reindex", "-f", str(mended))
    assert shell.output("bag", "convert", str(mended), str(mcap)) == f"{mcap}: 30 messages\n"
    assert shell.output("bag", "convert", str(mcap), str(mended), "--compression", "bz2")
    assert list(BagReader(mended).messages()) == list(BagReader(bag).messages())


def test_copies_and_playback_of_a_damaged_recording_name_the_damage(
    graph: LiveGraph, bag: Path, tmp_path: Path, shell: Shell
) -> None:
    target = str(tmp_path / "b.mcap")
    bag.write_bytes(bag.read_bytes()[:5000])
    warning = f"{bag}: its index is broken"
    since = ("--from", "2023-11-14T22:13+00:00")
    for words in (("filter", str(bag), target, "True"), ("cut", str(bag), "-o", target, *since)):
        result = shell("bag", *words)
        assert result.code == 0
        assert result.err.startswith(warning)
        assert "only its complete part is read" in result.err
    played, _ = _started(graph, "play", "-d", "0", "-i", str(bag)).communicate(timeout=60)
    assert played.startswith(warning)
    # A recording in progress has no index yet, and is not damaged.
    active = bag.rename(f"{bag}.active")
    assert shell("bag", "cut", str(active), "-o", target, *since).err == ""


@pytest.mark.parametrize(
    "words",
    [
        ("bag", "convert", "a.bag", "b.mcap"),
        ("bag", "compress", "--output-dir", "b", "a.bag"),
        ("export", "a.bag", "-o", "b.csv", "-t", "/a"),
    ],
)
async def test_a_signal_leaves_no_incomplete_file(tmp_path: Path, words: tuple[str, ...]) -> None:
    write_bag(tmp_path / "a.bag", 100_000, chunk_bytes=100_000)

    def new_files() -> list[Path]:
        return [each for each in tmp_path.rglob("*") if each.is_file() and each.name != "a.bag"]

    # A shell that starts a command in the background may ignore SIGHUP.
    command = subprocess.Popen(
        [*ROSTETHER, *words], cwd=tmp_path, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL)
    )
    await until(lambda: any(each.stat().st_size for each in new_files()), "the new file")
    command.send_signal(signal.SIGHUP)
    assert command.wait(60) == 128 + signal.SIGHUP
    assert new_files() == []


def test_what_makes_no_sense_is_reported(tmp_path: Path, bag: Path, shell: Shell) -> None:
    assert "No such file" in shell.failure("bag", "info", str(tmp_path / "none.bag"))
    assert "is not a bag" in shell.failure("bag", "info", __file__)
    assert "recording must end with .bag, .mcap or .db3;" in shell.failure(
        "bag", "convert", str(bag), str(tmp_path / "a.txt")
    )
    assert "--all" in shell.failure("bag", "record", code=2)
    assert "--size or --duration" in shell.failure("bag", "record", "-a", "--split", code=2)
    assert "not a duration" in shell.failure("bag", "record", "-a", "--duration", "soon", code=2)
    assert shell.failure("bag", "record", "-a", "-O", ".").startswith(". is a folder; give the name")


@pytest.mark.parametrize("verb", [("bag", "info"), ("bag", "check"), ("bag", "reindex"), ("export",)])
def test_what_is_not_a_file_is_refused_at_once(tmp_path: Path, shell: Shell, verb: tuple[str, ...]) -> None:
    for name in ("a.bag", "a.mcap", "a.db3", "folder/metadata.yaml", "folder/a_0.mcap"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        os.mkfifo(path)
        assert f"{path} is a FIFO" in shell.failure(*verb, str(path))
    (tmp_path / "folder" / "metadata.yaml").unlink()
    assert "a_0.mcap is a FIFO" in shell.failure(*verb, str(tmp_path / "folder"))
    assert "/dev/null is a device" in shell.failure(*verb, "/dev/null")


@pytest.mark.parametrize(
    ("name", "content", "reported"),
    [
        ("a.mcap", b"{}" * 50, "it is not an MCAP file"),
        ("a.mcap.active", b"\x89MCAP", "it is truncated: it has only 5 bytes"),
        ("a.mcap", b"\x89MCAP1\r\n" + bytes(50), "an unsupported MCAP version"),
        ("a.db3", b"{}" * 50, "not a SQLite file"),
        ("a.db3", b"SQLite", "not a SQLite file"),
        ("a.db3", b"", "is empty"),
        ("a.bag", b"#ROSBAG", "is truncated: it has only 7 bytes"),
    ],
)
def test_what_is_broken_is_reported_by_its_ending(
    tmp_path: Path, shell: Shell, name: str, content: bytes, reported: str
) -> None:
    (tmp_path / name).write_bytes(content)
    failure = shell.failure("bag", "info", str(tmp_path / name))
    assert reported in failure
    assert "\n" not in failure


def test_names_do_not_matter_if_the_content_is_clear(tmp_path: Path, bag: Path, shell: Shell) -> None:
    for name in ("a.mcap", "a.db3"):
        (tmp_path / name).write_bytes(bag.read_bytes())
        assert "messages:    30\n" in shell.output("bag", "info", str(tmp_path / name))


@pytest.mark.parametrize("words", [(), ("--loop",)])
def test_a_start_beyond_the_end_is_reported(graph: LiveGraph, bag: Path, words: tuple[str, ...]) -> None:
    player = _started(graph, "play", "-d", "0", "--start", "100", *words, str(bag))
    printed, _ = player.communicate(timeout=60)
    assert player.returncode == 0
    assert printed == (
        "WARNING: --start 100 is after the end; the recording lasts 0.290 s; nothing is played\n"
        "played 0 messages\n"
    )


def test_a_recording_that_got_nothing_is_reported(graph: LiveGraph, tmp_path: Path) -> None:
    recorder = _started(graph, "record", "-q", "--duration", "0.1", "-O", str(tmp_path / "none.bag"), "/no")
    printed, _ = recorder.communicate(timeout=60)
    assert recorder.returncode == 0
    assert printed.startswith("WARNING: no messages were received;")
    assert printed.count("\n") == 1


def test_recorded_until_interrupted_and_played_again(graph: LiveGraph, tmp_path: Path, shell: Shell) -> None:
    node = graph.node("/node")
    publisher = graph.do(node.advertise("/chat", STRING))
    path = tmp_path / "chat.bag"
    begun: list[bytes] = []
    graph.do(node.subscribe("/begin_write", ANY_MESSAGE, begun.extend))
    recorder = _started(graph, "record", "--publish", "-O", str(path), "/chat", "__name:=keeper")
    graph.wait_until(lambda: publisher.subscriber_count == 1)
    payloads = [text(str(number)) for number in range(20)]
    graph.do(_published(publisher, payloads))
    active = tmp_path / "chat.bag.active"
    graph.wait_until(lambda: begun == [text(str(path))])
    graph.wait_until(lambda: active.stat().st_size > 4117)
    recorder.send_signal(2)
    printed, _ = recorder.communicate(timeout=60)
    assert recorder.returncode == 0, printed
    assert "20 messages" in printed
    graph.do(publisher.close())
    received: list[bytes] = []
    graph.do(node.subscribe("/again", ANY_MESSAGE, received.extend))
    player = _started(graph, "play", "--wait-for-subscribers", "-i", str(path), "/chat:=/again")
    printed, _ = player.communicate(timeout=60)
    assert (player.returncode, printed) == (0, "played 20 messages\n")
    graph.wait_until(lambda: len(received) == 20)
    assert received == payloads


def test_files_may_follow_the_topics(graph: LiveGraph, bag: Path, shell: Shell) -> None:
    player = _started(graph, "play", "-d", "0", "-i", "--topics", "/a", "--bags", str(bag))
    printed, _ = player.communicate(timeout=60)
    assert (player.returncode, printed) == (0, "played 15 messages\n")
    assert "name a file to play" in shell.failure("bag", "play", "--topics", "/a", code=2)


def test_keys_step_and_end_it(graph: LiveGraph, bag: Path) -> None:
    received: list[bytes] = []
    node = graph.node("/node")
    for topic in ("/a", "/b"):
        graph.do(node.subscribe(topic, ANY_MESSAGE, received.extend))
    keyboard, terminal = pty.openpty()
    try:
        player = _started(graph, "play", "--pause", "--wait-for-subscribers", str(bag), stdin=terminal)
        assert player.stdout is not None
        assert "Space pauses" in player.stdout.readline()
        for count in (1, 2):
            os.write(keyboard, b"s")
            graph.wait_until(lambda count=count: len(received) == count)  # type: ignore[misc]
        os.write(keyboard, b"q")
        assert "played 2 messages" in player.communicate(timeout=60)[0]
    finally:
        os.close(keyboard)
        os.close(terminal)


async def _published(publisher: object, payloads: list[bytes]) -> None:
    publisher.publish_raw(payloads)  # type: ignore[attr-defined]


def test_compressed_in_its_place_and_back(tmp_path: Path, bag: Path, shell: Shell) -> None:
    before = list(BagReader(bag).messages())
    assert "30 messages" in shell.output("bag", "compress", str(bag))
    assert BagReader(bag).compressions[0].name == "bz2"
    assert "overwrite it with -f" in shell.failure("bag", "decompress", str(bag))
    shell.output("bag", "decompress", "-f", "-q", str(bag))
    assert BagReader(bag).compressions[0].name == "none"
    shell.output("bag", "compress", "--lz4", "--output-dir", str(tmp_path / "small"), str(bag))
    small = BagReader(tmp_path / "small" / "a.bag")
    assert small.compressions[0].name == "lz4"
    assert list(BagReader(bag).messages()) == list(small.messages()) == before


def test_filter_shows_what_is_asked(bag: Path, tmp_path: Path, shell: Shell) -> None:
    target = str(tmp_path / "b.bag")
    printed = shell.output("bag", "filter", "-p", "m.data", str(bag), target, "t.to_sec() < 1700000000.14")
    assert printed.splitlines()[:3] == ["MATCH message 0", "MATCH message 1", "NO MATCH message 2"]
    assert "there is no name '__import__';" in shell.failure(
        "bag", "filter", str(bag), target, "__import__('os')"
    )


def test_a_chunk_that_is_broken_is_skipped_by_reindex(tmp_path: Path, shell: Shell) -> None:
    path = tmp_path / "a.bag"
    write_bag(path, compression="bz2")
    data = bytearray(path.read_bytes())
    place = data.index(b"BZh", len(data) // 3)
    data[place + 20] ^= 0xFF
    path.write_bytes(data)
    assert "compressed with bz2 is broken" in shell("bag", "check", str(path)).out
    assert "messages kept" in shell.output("bag", "reindex", str(path))
    assert "no errors" in shell.output("bag", "check", str(path))
    assert 15 < len(list(BagReader(path).messages())) < 30


def test_a_terminal_shows_where_it_is_and_space_pauses_and_continues(
    graph: LiveGraph, tmp_path: Path
) -> None:
    bag = tmp_path / "long.bag"
    write_bag(bag, 3000)
    received: list[bytes] = []
    graph.do(graph.node("/node").subscribe("/a", ANY_MESSAGE, received.extend))
    keyboard, terminal = pty.openpty()
    termios.tcsetwinsize(terminal, (24, 80))
    shown = ""

    def is_shown(pattern: str) -> bool:
        nonlocal shown
        while select.select([keyboard], [], [], 0.02)[0]:
            shown += os.read(keyboard, 65536).decode()
        return re.search(pattern, shown) is not None

    player = subprocess.Popen(
        [*ROSTETHER, "bag", "play", "--loop", str(bag), "--topics", "/a"],
        env={**os.environ, "ROS_MASTER_URI": graph.uri},
        stdin=terminal,
        stdout=terminal,
        stderr=terminal,
    )
    try:
        graph.wait_until(lambda: len(received) > 3 and is_shown(r"\[RUNNING\]  time 17000000\d\d"))
        os.write(keyboard, b" ")
        graph.wait_until(lambda: is_shown(r"\[PAUSED \][^\r]*\r"))
        count = len(received)
        os.write(keyboard, b"s")
        graph.wait_until(lambda: len(received) > count)
        shown = ""
        os.write(keyboard, b" ")
        graph.wait_until(lambda: is_shown(r"\[RUNNING\]") and len(received) > count + 3)
        os.write(keyboard, b"q")
        graph.wait_until(lambda: is_shown(r"played \d+ messages"))
        assert player.wait(60) == 0
        lines = [re.sub(r"\033\[\w*", "", line) for line in re.split(r"[\r\n]+", shown)]
        assert max(map(len, lines)) < 80
    finally:
        player.kill()
        player.wait()
        os.close(keyboard)
        os.close(terminal)


def test_a_terminal_shows_rates_and_sizes_while_recording(graph: LiveGraph, tmp_path: Path) -> None:
    publisher = graph.do(graph.node("/node").advertise("/chat", STRING))
    keyboard, terminal = pty.openpty()
    termios.tcsetwinsize(terminal, (24, 80))
    recorder = subprocess.Popen(
        [*ROSTETHER, "bag", "record", "-O", str(tmp_path / "a.bag"), "/chat"],
        env={**os.environ, "ROS_MASTER_URI": graph.uri},
        stdin=terminal,
        stdout=subprocess.DEVNULL,
        stderr=terminal,
    )
    try:
        graph.wait_until(lambda: publisher.subscriber_count == 1)
        graph.do(_published(publisher, [text("x" * 1000)] * 50))
        shown = ""
        line = r"\[\d+ s\]  50 messages, \d+/s   5\d\.\d KB, [\d.]+ K?B/s   1 topic"
        while not re.search(line, shown):
            assert select.select([keyboard], [], [], 60)[0], shown
            shown += os.read(keyboard, 65536).decode()
        recorder.send_signal(2)
        assert recorder.wait(60) == 0
    finally:
        recorder.kill()
        recorder.wait()
        os.close(keyboard)
        os.close(terminal)


def test_cut_a_time_out_of_a_folder(bag: Path, tmp_path: Path, shell: Shell) -> None:
    start = datetime.fromtimestamp(START_NS // NS_PER_S)
    target = tmp_path / "seen.mcap"
    printed = shell.output(
        *("bag", "cut", str(bag.parent), "-o", str(target), "--duration", "5m", "-t", "/a"),
        *("--from", f"{start:%Y-%m-%d %H:%M:%S}"),
    )
    assert printed.startswith(f"{target}: 15 messages from 1 recording, from ")
    failed = shell.failure("bag", "cut", str(bag), "-o", str(target), "--from", "2020-01-01 10:00")
    assert "nothing was recorded at Jan 01 2020 10:00:00.00" in failed
    assert "the recordings reach from Nov 1" in failed
    failed = shell.failure(
        "bag", "cut", str(bag), "-o", str(target), "--from", "10:00", "-t", "/A*", "-t", "/x"
    )
    assert "no recorded topic is /A* or /x; recorded: /a, /b" in failed
