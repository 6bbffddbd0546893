from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.transports.capture import Capture
from rostether.transports.replay import MAX_LINKS, CaptureListener
from rostether.transports.transport import Transport
from unit.bridge.virtual_time import run
from unit.transports.recorder import Recorder

FIRST = '{"capture": "arm"}'


class Host:
    """Accepts each new link."""

    def __init__(self) -> None:
        self.peers: list[str] = []
        self.links: list[Recorder] = []
        self.chunks: list[tuple[float, int, bytes]] = []

    def take(self, transport: Transport) -> None:
        number = len(self.links) + 1
        recorder = Recorder()
        hear = recorder.data_received

        def data_received(data: bytes) -> None:
            self.chunks.append((round(asyncio.get_running_loop().time() - 1000.0, 3), number, data))
            hear(data)

        recorder.data_received = data_received  # type: ignore[method-assign]
        self.links.append(recorder)
        self.peers.append(transport.peer)
        transport.start(recorder)
        transport.write(b"you do not listen anyway")


def capture_of(tmp_path: Path, *lines: str) -> Capture:
    path = tmp_path / "arm.jsonl"
    path.write_text("\n".join([FIRST, *lines]) + "\n")
    return Capture(path)


async def played(capture: Capture, speed: float | None = 1.0) -> Host:
    host = Host()
    listener = CaptureListener(capture, host.take, speed=speed)
    await listener.play()
    await asyncio.sleep(0.01)
    return host


def device(time_s: float, data: str, link: int = 1) -> str:
    return f'{{"t": {time_s}, "from": "device", "hex": "{data}", "link": {link}}}'


LINES = (
    device(1.0, "aa"),
    '{"t": 1.2, "from": "host", "hex": "ffff"}',
    device(1.5, "bb"),
    '{"t": 2, "event": "opened", "link": 2, "peer": "tcp 10.0.0.7:5"}',
    device(2.5, "cc", 2),
    '{"t": 3, "event": "closed"}',
    '{"t": 4, "event": "opened", "link": 3}',
    device(5.0, "dd", 3),
)


def test_the_device_sends_at_the_recorded_times(tmp_path: Path) -> None:
    host = run(played(capture_of(tmp_path, *LINES)))
    assert host.chunks == [(1.0, 1, b"\xaa"), (1.5, 1, b"\xbb"), (2.5, 2, b"\xcc"), (5.0, 3, b"\xdd")]
    assert [len(link.losses) for link in host.links] == [1, 1, 1]
    assert set(host.peers) == {f"capture {tmp_path}/arm.jsonl"}


def test_four_times_as_fast(tmp_path: Path) -> None:
    host = run(played(capture_of(tmp_path, *LINES), 4.0))
    assert [time_s for time_s, _, _ in host.chunks] == [0.25, 0.375, 0.625, 1.25]


def test_without_pauses(tmp_path: Path) -> None:
    host = run(played(capture_of(tmp_path, *LINES), None))
    assert [(number, data) for _, number, data in host.chunks] == [
        (1, b"\xaa"),
        (1, b"\xbb"),
        (2, b"\xcc"),
        (3, b"\xdd"),
    ]
    assert host.chunks[-1][0] < 0.1


def test_a_link_that_opens_again_is_a_new_link(tmp_path: Path) -> None:
    opened = '{"t": 1, "event": "opened"}'
    host = run(played(capture_of(tmp_path, device(0.5, "aa"), opened, device(1.5, "bb"))))
    assert [number for _, number, _ in host.chunks] == [1, 2]


def test_a_host_that_hangs_up_does_not_stop_the_capture(tmp_path: Path) -> None:
    async def hang_up() -> Host:
        host = Host()

        def take(transport: Transport) -> None:
            host.take(transport)
            transport.close()

        await CaptureListener(capture_of(tmp_path, *LINES), take, speed=None).play()
        return host

    assert not run(hang_up()).chunks


def test_a_slow_host_is_waited_for(tmp_path: Path) -> None:
    async def play_slowly() -> None:
        capture = capture_of(tmp_path, *(device(0.0, "aa" * 4096) for _ in range(100)))
        transports: list[Transport] = []
        playing = asyncio.create_task(CaptureListener(capture, transports.append).play())
        await asyncio.sleep(1.0)
        assert not playing.done()
        recorder = Recorder()
        transports[0].start(recorder)
        await playing
        await recorder.until(lambda seen: len(seen.data) == 100 * 4096)

    run(play_slowly())


def test_links_at_once_are_bounded(tmp_path: Path) -> None:
    async def play_many() -> Host:
        host = Host()
        capture = capture_of(tmp_path, *(device(0.1, "aa", link) for link in range(1, 1000)))
        with pytest.raises(ConfigError, match="more than 128 links"):
            await CaptureListener(capture, host.take).play()
        await asyncio.sleep(0.01)
        return host

    host = run(play_many())
    assert [len(link.losses) for link in host.links] == [1] * MAX_LINKS


def test_a_bad_line_hangs_up(tmp_path: Path) -> None:
    async def play_badly() -> Host:
        host = Host()
        with pytest.raises(ConfigError, match="line 3"):
            await CaptureListener(capture_of(tmp_path, device(0.1, "aa"), "{}"), host.take).play()
        await asyncio.sleep(0.01)
        return host

    host = run(play_badly())
    assert [len(link.losses) for link in host.links] == [1]
