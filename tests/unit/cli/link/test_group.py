"""`link record`, `show` and `replay` as processes, with a board at a pseudo-terminal."""

from __future__ import annotations

import asyncio
import json
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from contract.graphs import wait_for_snapshot
from interop.ros1_peers import free_port
from programs import started
from rostether.cli.bag.formatting import MEGABYTE
from rostether.cli.bridge.serve import serve
from rostether.joining import join
from rostether.ros1.master.server import MasterServer
from rostether.transports.capture import Capture, Chunk
from rostether.transports.opening import open_transport
from unit.bridge.sketch_board import SketchBoard, every, hello, publish
from unit.cli.command_shell import Shell
from waiting import until

VECTORS = Path(__file__).parents[3] / "vectors"


@asynccontextmanager
async def board_at(path: Path, period_s: float = 0.1) -> AsyncIterator[None]:
    """A board that sends hello, by default ten times a second."""
    wire = await open_transport(f"pty:{path}")
    board = SketchBoard(wire, turn=every(period_s, publish("chatter", hello))).publisher("chatter").plug_in()
    try:
        yield
    finally:
        await board.unplug()
        await wire.wait_closed()


@asynccontextmanager
async def master() -> AsyncIterator[dict[str, str]]:
    server = await MasterServer.start(port=0)
    try:
        yield {"ROS_MASTER_URI": server.uri}
    finally:
        await server.close()


def recorded_hellos(file: Path) -> int:
    """Return the number of the board's hellos in a capture."""
    chunks = (each for each in Capture(file).entries() if isinstance(each, Chunk) and each.from_device)
    return b"".join(each.data for each in chunks).count(b"\5\0\0\0hello")


async def receive(environ: dict[str, str], topic: str, count: int) -> None:
    async with asyncio.timeout(60), join("listener", environ=environ) as graph:
        async for _ in graph.messages(topic):
            count -= 1
            if not count:
                return


async def test_recorded_killed_and_played_again(tmp_path: Path) -> None:
    file = tmp_path / "problem.jsonl"
    async with (
        board_at(tmp_path / "arm"),
        master() as environ,
        started("link", "record", f"{tmp_path}/arm", str(file), **environ) as record,
    ):
        await record.wait_for(f"Recording the lines to {file}")
        await receive(environ, "/chatter", 5)
        # The recorder writes a few times a second.
        await until(lambda: recorded_hellos(file) >= 5, "the messages in the file")
        await record.stop(signal.SIGKILL)
    chunks = [each for each in Capture(file).entries() if isinstance(each, Chunk)]
    assert {each.from_device for each in chunks} == {True, False}
    assert recorded_hellos(file) >= 5
    async with master() as environ, join("looker", environ=environ) as graph:
        # A replay does not wait for late subscribers.
        receiving = asyncio.create_task(receive(environ, "/chatter", 3))
        await wait_for_snapshot(graph.raw, lambda found: "/chatter" in found.topics)
        async with started("link", "replay", str(file), "--name", "ghost", **environ) as play:
            await receiving
            text = await play.finish()
        assert play.process.returncode == 0
        assert "/ghost: Setup publisher on chatter [std_msgs/String]" in text
        assert text.splitlines()[-1].startswith("played ")


async def test_serve_records_and_reports_it_at_the_end(tmp_path: Path) -> None:
    file = tmp_path / "problem.jsonl"
    async with (
        board_at(tmp_path / "arm"),
        master() as environ,
        started("serve", f"{tmp_path}/arm", "--record-line", str(file), **environ) as serve,
    ):
        await receive(environ, "/chatter", 2)
        await serve.stop(signal.SIGINT)
        assert f"{file} holds" in serve.text
    last = json.loads(file.read_text().splitlines()[-1])
    assert last["event"] == "closed"


async def test_the_limit_is_reported_and_the_board_still_served(tmp_path: Path) -> None:
    file = tmp_path / "problem.jsonl"
    async with (
        board_at(tmp_path / "arm", 0.01),
        master() as environ,
        started(
            "link", "record", f"{tmp_path}/arm", str(file), "--record-limit", "0.01", **environ
        ) as record,
    ):
        await receive(environ, "/chatter", 3)
        await record.wait_for("has reached 0.01 MB: the recording has stopped", timeout_s=60)
        await receive(environ, "/chatter", 3)
    assert file.stat().st_size <= 0.01 * MEGABYTE


@pytest.mark.parametrize("code", [0, 1])
def test_record_has_the_exit_code_of_serve(
    shell: Shell, tmp_path: Path, code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serve, "callback", lambda **_: code)
    assert shell("link", "record", "tcp://:0", str(tmp_path / "a.jsonl")).code == code


async def test_no_file_is_overwritten(tmp_path: Path) -> None:
    file = tmp_path / "problem.jsonl"
    file.write_text("precious")
    async with master() as environ, started("link", "record", "tcp://:0", str(file), **environ) as record:
        text = await record.finish()
    assert record.process.returncode == 1
    assert "already exists; give" in text.splitlines()[-1]
    assert file.read_text() == "precious"


async def received_of(file: Path, *options: str) -> int:
    """Replay a capture to a waiting subscriber; return the number of messages that it got."""
    received = 0
    async with master() as environ, join("listener", environ=environ) as graph:

        async def count() -> None:
            nonlocal received
            async for _ in graph.messages("/adc", "rosserial_arduino/Adc", queue_size=5000):
                received += 1

        counting = asyncio.create_task(count())
        async with asyncio.timeout(60):
            while "/adc" not in (await graph.snapshot()).topics:
                await asyncio.sleep(0.01)
        async with started("link", "replay", str(file), *options, **environ) as play:
            text = await play.finish()
        assert "1 topic or service, 1429 messages" in text
        seen = -1
        while seen < received:
            # Messages of the ended command may still be in the socket.
            seen = received
            await asyncio.sleep(0.05)
        counting.cancel()
        await asyncio.gather(counting, return_exceptions=True)
    return received


@pytest.mark.parametrize("options", [("--fast",), ("--speed", "1000")], ids=" ".join)
async def test_a_recorded_session_without_pauses(options: tuple[str, ...]) -> None:
    """A subscriber that waits gets every message; the capture's own count of them is 1,429."""
    received = 0
    for _ in range(5):
        # On a busy machine a subscriber may need longer than the command waits for it.
        received = max(received, await received_of(VECTORS / "adc.jsonl", *options))
        if received >= 1400:
            break
    # The first messages are in one chunk with the announcement, before a subscriber can connect.
    assert 1400 <= received <= 1429


async def test_replay_is_the_master_where_none_is() -> None:
    uri = f"http://127.0.0.1:{free_port()}"
    async with started(
        "link", "replay", str(VECTORS / "helloworld.jsonl"), "--speed", "20", ROS_MASTER_URI=uri
    ) as play:
        text = await play.finish()
    assert play.process.returncode == 0
    assert "Started a ROS master" in text
    assert "/helloworld: Setup publisher on chatter" in text


def test_show(shell: Shell) -> None:
    lines = shell.output("link", "show", str(VECTORS / "pubsub.jsonl")).splitlines()
    assert lines[0] == "    2.626472  <- host      0      0 B  requests the topics"
    assert lines[3].endswith(
        "publisher 'chatter' [std_msgs/String] id 125, 280 bytes, md5 992ce8a1687cec8c8bd883ec73ca41d1"
    )
    assert lines[5] == "    3.504007  board ->   125     16 B  chatter"
    assert lines[-1] == (
        "protocol version 2, 12.0 s; from the board 23 frames, 1 fault; from the host 10 frames, 0 faults"
    )


def test_show_only_faults(shell: Shell) -> None:
    lines = shell.output("link", "show", "--faults", str(VECTORS / "boot_text.jsonl")).splitlines()
    assert len(lines) > 2
    assert all(" ! " in line for line in lines[:-1])


def test_show_json(shell: Shell) -> None:
    records = shell("link", "show", "--json", str(VECTORS / "protocol1.jsonl")).records
    logged = next(each for each in records if each["topic_id"] == 7)
    assert logged["what"] == "logs INFO 'led on'"
    assert (logged["from"], logged["fault"]) == ("device", None)


@pytest.mark.parametrize("verb", ["show", "replay"])
def test_bad_files(shell: Shell, tmp_path: Path, verb: str) -> None:
    file = tmp_path / "problem.jsonl"
    assert "No such file" in shell.failure("link", verb, str(file))
    file.write_text("text\n")
    assert f"{file}, line 1: JSON is malformed" in shell.failure("link", verb, str(file))


def test_a_damaged_line_is_named_after_those_before_it(shell: Shell, tmp_path: Path) -> None:
    file = tmp_path / "problem.jsonl"
    file.write_text('{"capture": "x"}\n{"t": 1, "from": "host", "hex": "fffe0000ff0000ff"}\n{"t": 2}\n')
    result = shell("link", "show", str(file))
    assert result.code == 1
    assert "requests the topics" in result.out
    assert f"{file}, line 3: neither an event, nor bytes" in result.err


async def test_a_capture_without_a_board(tmp_path: Path) -> None:
    file = tmp_path / "problem.jsonl"
    file.write_text('{"capture": "x"}\n{"t": 0.1, "from": "host", "hex": "fffe0000ff0000ff"}\n')
    async with master() as environ, started("link", "replay", str(file), **environ) as play:
        text = await play.finish()
    assert play.process.returncode == 1
    assert "contains no bytes of a board" in text.splitlines()[-1]
