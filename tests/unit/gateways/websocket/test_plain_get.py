"""Plain requests on the port of a gateway, over real sockets."""

from __future__ import annotations

import asyncio
import resource

import pytest
from msgspec.structs import replace

from rostether.gateways.foxglove.settings import FoxgloveLimits, FoxgloveSettings
from rostether.gateways.websocket.site import Site
from unit.gateways.foxglove.protocol_client import TIMEOUT_S, Stage, stage
from waiting import until

SITE = Site({"index.html": b"<p>page</p>", "large.bin": bytes(range(256)) * 40_000})
FREE = FoxgloveSettings(port=0)
MANY = 4_000
AT_ONCE = 20


async def asked(there: Stage, request: bytes) -> bytes:
    """Send a request, and return the answer until the server closes the connection."""
    reader, writer = await asyncio.open_connection("127.0.0.1", there.gateway.port)
    writer.write(request)
    try:
        return await asyncio.wait_for(reader.read(-1), TIMEOUT_S)
    finally:
        writer.close()


def get(path: str, *, method: str = "GET", host: str = "localhost", more: str = "") -> bytes:
    return f"{method} {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n".encode()


async def test_the_page_is_served_on_the_gateway_s_port() -> None:
    async with stage(FREE, site=SITE) as there, there.client() as viewer:
        reply = await asked(there, get("/"))
        assert reply.startswith(b"HTTP/1.1 200 OK\r\n")
        assert b"\r\nContent-Security-Policy: default-src 'none';" in reply
        assert reply.endswith(b"\r\nContent-Length: 11\r\nConnection: close\r\n\r\n<p>page</p>")
        assert await viewer.wait("serverInfo")


@pytest.mark.parametrize("chunk", [1, 7, 10_000])
async def test_a_request_in_pieces_is_the_same(chunk: int) -> None:
    async with stage(FREE, site=SITE) as there:
        reader, writer = await asyncio.open_connection("127.0.0.1", there.gateway.port)
        request = get("/", more="X-Long: " + "x" * 100 + "\r\n")
        for start in range(0, len(request), chunk):
            writer.write(request[start : start + chunk])
            await writer.drain()
        assert (await asyncio.wait_for(reader.read(-1), TIMEOUT_S)).endswith(b"<p>page</p>")
        writer.close()


async def test_a_large_file_comes_whole() -> None:
    async with stage(FREE, site=SITE) as there:
        reply = await asked(there, get("/large.bin"))
        assert len(reply.partition(b"\r\n\r\n")[2]) == 256 * 40_000


@pytest.mark.parametrize(
    ("request_bytes", "status"),
    [
        (get("/", method="HEAD"), b"200 OK"),
        (get("/none"), b"404 Not Found"),
        (get("/../../etc/passwd"), b"404 Not Found"),
        (get("/", method="DELETE"), b"405 Method Not Allowed"),
        (get("/", more="Content-Length: 2\r\n") + b"{}", b"400 Bad Request"),
        (get("/", method="POST", more="Content-Length: 4\r\n") + b"x=%2", b"405 Method Not Allowed"),
        (get("/", host="evil.example"), b"403 Forbidden"),
        (get("/", host="evil.example:8765"), b"403 Forbidden"),
    ],
)
async def test_what_is_not_a_file_is_answered_briefly(request_bytes: bytes, status: bytes) -> None:
    async with stage(FREE, site=SITE) as there:
        reply = await asked(there, request_bytes)
        assert reply.startswith(b"HTTP/1.1 " + status + b"\r\n")
        assert b"<p>page</p>" not in reply


async def test_pages_that_may_connect_may_be_asked_for() -> None:
    async with stage(replace(FREE, token="secret"), site=SITE) as there:
        # The token does not help here.
        assert b"or use --origin http://panel.example:8765" in await asked(
            there, get("/?token=secret", host="panel.example:8765")
        )
    settings = replace(FREE, origins=("https://panel.example",))
    async with stage(settings, site=SITE) as there:
        assert b" 200 OK" in await asked(there, get("/", host="panel.example"))
        assert b" 403 " in await asked(there, get("/", host="other.example"))


async def test_the_page_needs_no_token_but_its_connection_does() -> None:
    async with stage(replace(FREE, token="secret"), site=SITE) as there:
        assert b" 200 OK" in await asked(there, get("/"))
        upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        upgrade += "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
        assert b" 403 " in await asked(there, get("/", more=upgrade))


async def test_without_a_page_a_plain_request_asks_for_an_upgrade() -> None:
    async with stage(FREE) as there:
        assert b" 426 " in await asked(there, get("/"))


async def test_a_client_that_goes_on_sending_keeps_no_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.gateways.websocket.plain_answer._FILE_S", 0.1)
    limits = FoxgloveLimits(clients=1, others=0)
    async with stage(replace(FREE, limits=limits), site=SITE) as there:
        _, writer = await asyncio.open_connection("127.0.0.1", there.gateway.port)
        writer.write(get("/"))
        with pytest.raises(ConnectionError):
            async with asyncio.timeout(TIMEOUT_S):
                while True:
                    writer.write(b"more")
                    await writer.drain()
                    await asyncio.sleep(0.02)
        writer.close()
        assert b" 200 OK" in await asked(there, get("/"))


async def test_requests_for_files_take_no_place_of_a_client() -> None:
    limits = FoxgloveLimits(clients=1, others=2)
    async with stage(replace(FREE, limits=limits), site=SITE) as there:
        silent = [await asyncio.open_connection("127.0.0.1", there.gateway.port) for _ in range(2)]
        await until(lambda: there.connection_count == 2)
        async with there.client() as viewer:
            await viewer.wait("serverInfo")
        for _, writer in silent:
            writer.close()


@pytest.mark.slow
async def test_thousands_of_requests_leave_nothing_behind() -> None:
    """A viewer is served during the requests; connections, tasks and memory are as before."""
    async with stage(FREE, site=SITE) as there, there.client() as viewer:
        await asked(there, get("/"))
        tasks, memory_kb = len(asyncio.all_tasks()), 0

        async def ask(count: int) -> None:
            for _ in range(count):
                assert (await asked(there, get("/"))).endswith(b"<p>page</p>")

        for part in range(2):
            await asyncio.gather(*(ask(MANY // 2 // AT_ONCE) for _ in range(AT_ONCE)))
            used_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            if part == 0:
                memory_kb = used_kb
            await viewer.say("getParameters", parameterNames=[], id=f"part {part}")
            await viewer.wait("parameterValues")
            viewer.received.clear()
        assert used_kb - memory_kb < 5_000
        await until(lambda: there.connection_count == 1)
        assert len(asyncio.all_tasks()) <= tasks
