"""Recordings that clients start and stop, over real sockets."""

from __future__ import annotations

import asyncio
import ssl
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from rostether.errors import ConfigError
from rostether.gateways.foxglove import recordings as recordings_module
from rostether.gateways.foxglove.settings import FoxgloveSettings
from rostether.gateways.websocket.own_authority import own_certificate
from rostether.gateways.websocket.site import Site
from unit.gateways.foxglove.protocol_client import TIMEOUT_S, Stage, stage
from waiting import until

FREE = FoxgloveSettings(port=0)


class FakePlayback:
    """Plays nothing, and stores the requests."""

    def __init__(self, calls: list[object]) -> None:
        self.is_active = False
        self._calls = calls

    async def play(self, name: str, start_s: float, rate: float, *, is_prefixed: bool) -> None:
        self._calls.append((name, start_s, rate, is_prefixed))
        self.is_active = True

    async def pause(self, *, is_paused: bool) -> None:
        self._calls.append(is_paused)

    async def stop(self) -> None:
        if self.is_active:
            self._calls.append("stop playing")
        self.is_active = False


class FakeRecordings:
    """Records nothing, and stores the requests."""

    def __init__(self) -> None:
        self.is_active = False
        self.calls: list[object] = []
        self.playback = FakePlayback(self.calls)
        self.count = 0

    async def start(self, topics: Sequence[str], form: str) -> None:
        if self.is_active:
            raise ConfigError("it runs already")
        self.calls.append((tuple(topics), form))
        self.is_active = True

    async def stop(self) -> None:
        self.calls.append("stop")
        self.is_active = False

    async def state(self) -> Mapping[str, Any]:
        self.count += 1
        return {"active": {"messages": self.count} if self.is_active else None, "files": []}


async def test_a_client_starts_watches_and_stops(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recordings_module, "PERIOD_S", 0.01)
    recordings = FakeRecordings()
    async with stage(FREE, recordings=recordings) as there, there.client() as client, there.client() as other:
        assert "record" in client.of("serverInfo")[0]["metadata"]["features"].split(",")
        await client.say("listRecordings")
        assert (await client.wait("recordings"))["active"] is None
        await other.say("startRecording", topics=["/a"], format="mcap")
        await client.wait("recordings", lambda state: state["active"] and state["active"]["messages"] > 4)
        assert not other.of("recordings")
        await other.say("startRecording")
        await other.wait("status", lambda status: "it runs already" in status["message"])
        await client.say("stopRecording")
        await until(lambda: client.of("recordings")[-1]["active"] is None)
        assert recordings.calls == [(("/a",), "mcap"), "stop"]
        await client.say("startRecording", topics=[])
        await until(lambda: recordings.is_active)
    # The gateway has ended.
    assert recordings.calls[2:] == [((), "bag"), "stop"]


async def test_a_client_plays_a_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recordings_module, "PERIOD_S", 0.01)
    recordings = FakeRecordings()
    async with stage(FREE, recordings=recordings) as there, there.client() as client:
        await client.say("listRecordings")
        await client.say("playRecording", name="a.bag", start=1.5, rate=2, prefixed=False)
        # Reports come while it is played.
        await until(lambda: len(client.of("recordings")) > 4)
        await client.say("pausePlayback", paused=True)
        await client.say("stopPlayback")
        await client.say("playRecording", name="b.bag")
        await until(lambda: len(recordings.calls) == 4)
        assert recordings.calls == [
            ("a.bag", 1.5, 2.0, False),
            True,
            "stop playing",
            ("b.bag", 0.0, 1.0, True),
        ]
        await client.say("playRecording", name="b.bag", start=-1)
        await client.wait("status", lambda status: "expected number >= 0" in status["message"])
        await client.say("pausePlayback", paused=1)
        await client.wait("status", lambda status: "expected boolean" in status["message"])
    assert recordings.calls[4:] == ["stop playing"]


@pytest.mark.parametrize("op", ["startRecording", "stopRecording", "listRecordings"])
async def test_without_recordings_it_is_reported(op: str) -> None:
    async with stage(FREE) as there, there.client() as client:
        await client.say(op)
        assert "does not record" in (await client.wait("status"))["message"]


async def test_a_client_that_may_only_view_starts_no_recording() -> None:
    recordings = FakeRecordings()
    settings = replace(FREE, token="full", view_token="look")
    async with stage(settings, recordings=recordings) as there, there.client(path="/?token=look") as viewer:
        await viewer.say("startRecording")
        await viewer.say("stopRecording")
        await viewer.say("playRecording", name="a.bag")
        await viewer.say("stopPlayback")
        await until(lambda: len(viewer.of("status")) == 4)
        assert all("may only view" in each["message"] for each in viewer.of("status"))
        await viewer.say("listRecordings")
        await viewer.wait("recordings")
        assert recordings.calls == []


def files_in(folder: Path) -> Callable[[str], Path | None]:
    return lambda name: folder / name if name in ("drive.bag", "Fahrt ü #1.bag") else None


async def fetched(there: Stage, path: str, more: str = "") -> bytes:
    reader, writer = await asyncio.open_connection("127.0.0.1", there.gateway.port)
    writer.write(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n{more}\r\n".encode())
    try:
        return await asyncio.wait_for(reader.read(-1), TIMEOUT_S)
    finally:
        writer.close()


async def test_a_recording_is_downloaded_whole(tmp_path: Path) -> None:
    content = bytes(range(256)) * 20_000
    (tmp_path / "drive.bag").write_bytes(content)
    async with stage(FREE, site=Site({"index.html": b""}, files_in(tmp_path))) as there:
        head, _, body = (await fetched(there, "/recordings/drive.bag")).partition(b"\r\n\r\n")
        assert head.startswith(b"HTTP/1.1 200 OK\r\n")
        assert b"attachment; filename*=UTF-8''drive.bag" in head
        assert f"Content-Length: {len(content)}".encode() in head
        assert body == content
        (tmp_path / "Fahrt ü #1.bag").write_bytes(b"renamed")
        renamed = await fetched(there, "/recordings/Fahrt%20%C3%BC%20%231.bag")
        assert b"filename*=UTF-8''Fahrt%20%C3%BC%20%231.bag" in renamed
        assert renamed.endswith(b"renamed")
        assert (await fetched(there, "/recordings/none.bag")).startswith(b"HTTP/1.1 404 ")
        assert (await fetched(there, "/recordings/..%2Findex.html")).startswith(b"HTTP/1.1 404 ")
        assert (await fetched(there, "/recordings/../index.html")).startswith(b"HTTP/1.1 404 ")
        await until(lambda: there.connection_count == 0)


@pytest.mark.parametrize(
    ("path", "more", "status"),
    [
        ("?token=full", "", 200),
        ("?token=look", "", 200),
        ("", "Authorization: Bearer full\r\n", 200),
        ("", "", 403),
        ("?token=wrong", "", 403),
        ("?token=full", "Sec-Fetch-Site: cross-site\r\n", 403),
        ("?token=full", "Sec-Fetch-Site: same-origin\r\n", 200),
    ],
)
async def test_recordings_need_the_token(tmp_path: Path, path: str, more: str, status: int) -> None:
    (tmp_path / "drive.bag").write_bytes(b"content")
    settings = replace(FREE, token="full", view_token="look")
    async with stage(settings, site=Site({"index.html": b""}, files_in(tmp_path))) as there:
        reply = await fetched(there, f"/recordings/drive.bag{path}", more)
        assert reply.startswith(f"HTTP/1.1 {status} ".encode())
        assert (b"content" in reply) is (status == 200)


async def test_a_recording_is_downloaded_over_tls(tmp_path: Path) -> None:
    content = bytes(range(256)) * 20_000
    (tmp_path / "drive.bag").write_bytes(content)
    made = own_certificate(tmp_path / "tls")
    settings = replace(FREE, certificate=str(made.certificate), key=str(made.key))
    trust = ssl.create_default_context(cafile=str(made.authority))
    site = Site({"index.html": b"", "large.js": content}, files_in(tmp_path))
    async with stage(settings, site=site) as there:
        for path in ("/recordings/drive.bag", "/large.js"):
            reader, writer = await asyncio.open_connection(
                "127.0.0.1", there.gateway.port, ssl=trust, server_hostname="localhost"
            )
            writer.write(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            reply = await asyncio.wait_for(reader.read(-1), TIMEOUT_S)
            assert reply.partition(b"\r\n\r\n")[2] == content
            writer.close()
        await until(lambda: there.connection_count == 0)


async def test_a_client_that_half_closes_gets_its_recording(tmp_path: Path) -> None:
    content = bytes(5 << 20)
    (tmp_path / "drive.bag").write_bytes(content)
    async with stage(FREE, site=Site({"index.html": b""}, files_in(tmp_path))) as there:
        reader, writer = await asyncio.open_connection("127.0.0.1", there.gateway.port)
        writer.write(b"GET /recordings/drive.bag HTTP/1.1\r\nHost: localhost\r\n\r\n")
        writer.write_eof()
        reply = await asyncio.wait_for(reader.read(-1), TIMEOUT_S)
        assert len(reply.partition(b"\r\n\r\n")[2]) == len(content)
        writer.close()


async def test_a_client_that_goes_away_in_the_middle_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "drive.bag").write_bytes(bytes(50 << 20))
    async with stage(FREE, site=Site({"index.html": b""}, files_in(tmp_path))) as there:
        reader, writer = await asyncio.open_connection("127.0.0.1", there.gateway.port)
        writer.write(b"GET /recordings/drive.bag HTTP/1.1\r\nHost: localhost\r\n\r\n")
        await reader.readexactly(1000)
        writer.transport.abort()
        await until(lambda: there.connection_count == 0)
