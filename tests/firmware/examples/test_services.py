"""Examples with services, parameters and logs."""

from __future__ import annotations

import contextlib

import pytest

from firmware.examples.stage import build_example, open_bridge, running
from rostether.graph.typed_graph import TypedGraph
from rostether.simulation.simavr.simulated_board import SimulatedBoard

TEXT = "std_msgs/String"


async def test_service_server(kind: str) -> None:
    async with running("ServiceServer", kind) as stage:
        await stage.wait_for_service("/test_srv")
        for reported in ("hello", "world", "hello"):
            answer = await stage.graph.call(
                "/test_srv", "rosserial_arduino/Test", {"input": "anybody there?"}, timeout_s=60
            )
            assert answer.output == reported
        assert (await stage.message("/chatter", TEXT)).data == "hello world!"


async def test_service_client(kind: str) -> None:
    async def serve(graph: TypedGraph, _master: str) -> None:
        await graph.service_server(
            "/test_srv", "rosserial_arduino/Test", lambda request: {"output": request.input.upper()}
        )

    async with running("ServiceClient", kind, prepare=serve) as stage:
        assert (await stage.message("/chatter", TEXT)).data == "HELLO WORLD!"


async def test_one_board_calls_another(kind: str) -> None:
    server = await build_example("ServiceServer", "uno")
    async with contextlib.AsyncExitStack() as stack:
        client = await stack.enter_async_context(running("ServiceClient", kind))
        board = await stack.enter_async_context(await SimulatedBoard.start(server.elf))
        bridge = open_bridge(client.master_uri, client.reporter, f"{board.address}?name=server")
        await stack.enter_async_context(bridge)
        chatter = await client.listen("/chatter", TEXT)
        await chatter.wait_for(lambda text: text.data == "hello")
        await chatter.wait_for(lambda text: text.data == "world")


async def test_parameters(kind: str) -> None:
    async def set_parameters(graph: TypedGraph, _master: str) -> None:
        await graph.raw.set_param("/board", {"gains": [1.5, 0.25, 0.01], "name": "lefty", "period_ms": 20})

    async with running("Parameters", kind, prepare=set_parameters) as stage:
        gains = await stage.message("/gains", "std_msgs/Float32MultiArray")
        assert gains.data == pytest.approx([1.5, 0.25, 0.01])
        names = await stage.listen("/name", TEXT)
        messages = await names.next_messages(3)
        assert {message.data for message in messages} == {"lefty"}


async def test_parameters_that_are_not_set(kind: str) -> None:
    async with running("Parameters", kind) as stage:
        log = await stage.listen_to_log()
        gains = await stage.listen("/gains", "std_msgs/Float32MultiArray")
        assert (await gains.wait_for()).data == pytest.approx([1.0, 0.0, 0.1])
        assert (await stage.message("/name", TEXT)).data == "nobody"
        assert all(line.level <= 4 for line in log.messages)


async def test_logging(kind: str) -> None:
    async with running("Logging", kind) as stage:
        log = await stage.listen_to_log()
        await log.wait_for(lambda line: line.level == 16)
        await log.wait_for(lambda line: line.level == 16)
        one_round = [line for line in log.messages if line.name == "/board" and line.level != 1][-4:]
        assert [line.level for line in one_round] == [2, 4, 8, 16]
        assert [line.msg for line in one_round] == [
            "all is well",
            "unusual",
            "broken",
            "nothing works",
        ]
        assert (1, "a detail") in [(line.level, line.msg) for line in log.messages]
