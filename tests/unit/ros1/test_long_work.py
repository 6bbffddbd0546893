"""Large requests and answers of an XML-RPC server are limited, and other clients are answered meanwhile."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from typing import Any

import pytest

from rostether.errors import GraphError
from rostether.ros1 import long_work, xmlrpc_methods, xmlrpc_server
from rostether.ros1.graph_limits import GraphLimits
from rostether.ros1.master.server import MasterServer
from rostether.ros1.xmlrpc_client import XmlRpcClient
from rostether.ros1.xmlrpc_server import XmlRpcServer
from unit.ros1.xmlrpc_stage import RawClient, client_of, request, serving

pytestmark = pytest.mark.slow

LIMITS = GraphLimits(body_bytes=100_000)
# More than the server writes before the other client, which begins at the same time, has connected.
MANY = 50_000


class Diary:
    """Methods that record the time of their calls; another client calls `ping` repeatedly."""

    def __init__(self) -> None:
        self.entries: list[str] = []
        self.began = asyncio.Event()

    def note(self, entry: str) -> int:
        self.entries.append(entry)
        return 1

    def begin(self) -> int:
        self.began.set()
        return self.note("begin")

    def large(self) -> list[int]:
        return [1] * MANY

    def lazy(self) -> Iterator[object]:
        self.begin()

        def numbers() -> Iterator[int]:
            yield from range(MANY)
            self.entries.append("end")

        return numbers()

    def methods(self) -> dict[str, Any]:
        return {
            "begin": self.begin,
            "large": self.large,
            "lazy": self.lazy,
            "ping": lambda: self.note("ping"),
            "end": lambda: self.note("end"),
        }

    async def ping_meanwhile(self, server: XmlRpcServer) -> None:
        async with client_of(server) as client:
            await self.began.wait()
            await client.call("ping")


@pytest.fixture(autouse=True)
def short_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (long_work, xmlrpc_methods, xmlrpc_server):
        monkeypatch.setattr(module, "SLICE_S", 0.0)


async def test_another_client_is_answered_while_a_large_answer_is_written() -> None:
    diary = Diary()
    async with serving(diary.methods()) as server, client_of(server) as client:
        pinging = asyncio.create_task(diary.ping_meanwhile(server))
        assert await client.call("lazy") == list(range(MANY))
        await pinging
        assert diary.entries == ["begin", "ping", "end"]


async def test_another_client_is_answered_between_the_calls_of_a_multicall() -> None:
    diary = Diary()
    async with serving(diary.methods()) as server, client_of(server) as client:
        pinging = asyncio.create_task(diary.ping_meanwhile(server))
        calls = [{"methodName": name} for name in ("begin", "large", "end")]
        answers = await client.call("system.multicall", calls)
        await pinging
        assert answers == [[1], [[1] * MANY], [1]]
        assert diary.entries == ["begin", "ping", "end"]


async def test_another_client_is_answered_between_pipelined_requests() -> None:
    diary = Diary()
    async with serving(diary.methods()) as server:
        raw = await RawClient.connect(server)
        pinging = asyncio.create_task(diary.ping_meanwhile(server))
        raw.writer.write(request("begin") * 500 + request("end"))
        await pinging
        await raw.close()
        assert "end" not in diary.entries


async def test_an_answer_has_a_limit() -> None:
    async with (
        serving({"large": lambda: "x" * 100_001}, limits=LIMITS) as server,
        client_of(server) as client,
    ):
        with pytest.raises(
            GraphError, match=r"answer of large would need more than 100000 bytes; request less"
        ):
            await client.call("large")


async def test_the_answers_of_a_multicall_have_one_limit_together() -> None:
    called: list[int] = []

    def medium() -> str:
        called.append(1)
        return "x" * 10_000

    async with serving({"medium": medium}, limits=LIMITS) as server, client_of(server) as client:
        with pytest.raises(GraphError, match=r"system\.multicall would need more than 100000 bytes;"):
            await client.call("system.multicall", [{"methodName": "medium"}] * 400)
        assert len(called) <= 10, "what comes after is not computed"


async def test_a_failed_call_of_a_multicall_does_not_change_the_other_answers() -> None:
    methods = {"good": lambda: "good", "bad": lambda: [1, "x" * 70_000, 2**40]}
    async with serving(methods) as server, client_of(server) as client:
        calls = [{"methodName": name} for name in ("good", "bad", "good")]
        answers = await client.call("system.multicall", calls)
        assert isinstance(answers, list)
        assert (answers[0], answers[2]) == (["good"], ["good"])
        assert isinstance(answers[1], dict)
        assert "32 bits" in str(answers[1]["faultString"])


@pytest.mark.parametrize(
    ("method", "args"),
    [("getParam", ["/"]), ("getParamNames", []), ("getSystemState", []), ("getTopicTypes", [])],
)
async def test_every_answer_of_the_master_has_a_limit(method: str, args: list[str]) -> None:
    master = await MasterServer.start(port=0, limits=GraphLimits(body_bytes=20_000))
    client = XmlRpcClient(master.uri)
    try:
        for number in range(200):
            name = f"/{number}{'x' * 100}"
            await client.call("setParam", "/node", name, 1)
            await client.call("registerPublisher", "/node", name, "std_msgs/Empty", master.uri)
        with pytest.raises(GraphError, match="would need more than 20000 bytes;"):
            await client.call(method, "/node", *args)
        assert await client.call_status("getParam", "/node", f"/0{'x' * 100}") == (
            1,
            f"Parameter [/0{'x' * 100}]",
            1,
        )
    finally:
        await client.close()
        await master.close()


async def test_parameters_may_change_while_they_are_sent() -> None:
    master = await MasterServer.start(port=0)
    reader, writer = (XmlRpcClient(master.uri, timeout_s=60.0) for _ in range(2))
    try:
        await writer.call("setParam", "/node", "/", {f"k{number}": {"x": number} for number in range(20_000)})
        reading = [asyncio.create_task(reader.call("getParam", "/n", "/")) for _ in range(3)]
        for number in range(50):
            await writer.call("setParam", "/node", f"/new{number}", number)
            await writer.call("deleteParam", "/node", f"/k{number}")
        for answer in await asyncio.gather(*reading):
            assert isinstance(answer, list)
            assert isinstance(answer[2], dict)
            assert answer[2]["k19999"] == {"x": 19999}
    finally:
        await reader.close()
        await writer.close()
        await master.close()


async def test_clients_that_leave_their_answers_unread_make_room() -> None:
    limits = GraphLimits(body_bytes=8_000_000)
    async with (
        serving({"large": lambda: "x" * 7_900_000}, limits=limits) as server,
        client_of(server) as client,
    ):
        silent = [await RawClient.connect(server) for _ in range(16)]
        for raw in silent:
            raw.writer.write(request("large"))
        async with asyncio.timeout(60):
            while len(server._connections) == len(silent):
                await asyncio.sleep(0.01)
            assert await client.call("large") == "x" * 7_900_000
        unsent = sum(connection.unsent_bytes for connection in server._connections)
        assert unsent <= 4 * limits.body_bytes
        for raw in silent:
            await raw.close()
