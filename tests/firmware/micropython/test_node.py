"""The client library on MicroPython, with the real bridge, over USB, UART and TCP."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator
from itertools import pairwise
from pathlib import Path

from effort import effort
from firmware.micropython.boards import PROGRAMS, running, usb_board
from firmware.platforms.late_network import late_network
from firmware.platforms.node_harness import node_harness
from line_faults import FaultRates, LineFaults
from rostether.rosserial.frame import encode_frame
from rostether.transports.memory import Direction, Manipulator
from unit.bridge.lateness import lateness
from waiting import until

NODE = PROGRAMS / "platform_node.py"
# The most that fits into 280 bytes.
LONGEST_TEXT = 276


async def test_exchanges_messages_over_usb(library: Path) -> None:
    async with (
        usb_board(NODE, library, "usb") as board,
        node_harness() as harness,
        harness.bridge(board.address),
    ):
        await harness.exchange_messages()


async def test_exchanges_messages_over_a_uart(library: Path, tmp_path: Path) -> None:
    port = tmp_path / "port"
    async with node_harness() as harness, harness.bridge(f"pty:{port}"):
        await until(port.exists, "the port")
        async with running(NODE, library, "tty", str(port)):
            await harness.exchange_messages()


async def test_receives_a_message_whose_packets_arrive_late(library: Path) -> None:
    async with (
        node_harness() as harness,
        harness.bridge("tcp://127.0.0.1:0") as (address,),
        late_network(address) as network_address,
        running(NODE, library, "tcp", *_host_and_port(network_address)),
    ):
        await harness.wait_for_counts()
        assert await harness.ask("x" * 200) == "x" * 200


async def test_exchanges_messages_over_tcp_and_reconnects_to_another_bridge(library: Path) -> None:
    async with node_harness() as harness, contextlib.AsyncExitStack() as node:
        async with harness.bridge("tcp://127.0.0.1:0") as (address,):
            await node.enter_async_context(running(NODE, library, "tcp", *_host_and_port(address)))
            await harness.exchange_messages()
        async with harness.bridge(address):
            assert await harness.ask("hello again") == "hello again"


async def test_ctrl_c_stops_the_program_but_its_byte_in_a_message_does_not(library: Path) -> None:
    async with usb_board(NODE, library, "usb") as board:
        async with node_harness() as harness, harness.bridge(board.address):
            assert await harness.ask("\x03\r\x03") == "\x03\r\x03"
        # As mpremote does.
        Path(board.address).write_bytes(b"\r\x03")
        await until(lambda: board.has_ended, "the end of the program")


async def test_calls_a_service_from_a_task(library: Path) -> None:
    async with (
        usb_board(PROGRAMS / "tasks.py", library) as board,
        node_harness() as harness,
        harness.bridge(board.address),
    ):
        await until(lambda: len(harness.answers) >= 3, "responses")
        assert set(harness.answers) == {"pulled"}


async def test_exchanges_messages_without_the_modules_of_micropython(library: Path) -> None:
    # As on CircuitPython: its counter of milliseconds, and sockets with recv_into.
    async with (
        node_harness() as harness,
        harness.bridge("tcp://127.0.0.1:0") as (address,),
        running(NODE, library, "tcp", *_host_and_port(address), on_cpython=True),
    ):
        await harness.exchange_messages()
        # The counter has started again.
        await until(lambda: harness.counts[-1] > 100, "counts")
        assert await harness.ask("hello again") == "hello again"


async def test_exchanges_messages_over_the_second_usb_port_of_circuitpython(
    library: Path, tmp_path: Path
) -> None:
    port = tmp_path / "port"
    async with node_harness() as harness, harness.bridge(f"pty:{port}"):
        await until(port.exists, "the port")
        async with running(NODE, library, "usb", str(port), on_cpython=True):
            await harness.exchange_messages()


async def test_a_board_connects_again_after_a_reset(library: Path) -> None:
    async with (
        usb_board(NODE, library, "usb") as board,
        node_harness() as harness,
        harness.bridge(board.address),
    ):
        await harness.wait_for_counts()
        await board.reset()
        await until(lambda: any(b < a for a, b in pairwise(harness.counts)), "a counter that starts again")
        assert await harness.ask("hello") == "hello"


async def test_a_connection_to_a_host_that_is_no_longer_reachable_is_replaced(library: Path) -> None:
    began_s: list[float] = []

    async def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        began_s.append(time.monotonic())
        writer.write(encode_frame(0, b""))
        while await reader.read(65536):
            pass
        writer.close()

    async with await asyncio.start_server(accept, "127.0.0.1", 0) as server, lateness() as late:
        port = server.sockets[0].getsockname()[1]
        async with running(NODE, library, "tcp", "127.0.0.1", str(port)):
            await until(lambda: len(began_s) == 2, "its second connection")
    assert 8.0 < began_s[1] - began_s[0] < 12.0 + late.total_s


async def test_a_damaged_frame_loses_only_its_message(library: Path) -> None:
    # One frame in a hundred is damaged, in each direction; a frame has 280 bytes.
    faults = LineFaults(FaultRates(flip_per_byte=0.01 / 280), seed=4)
    is_damaging = True
    count = 150

    def damage(data: bytes, direction: Direction) -> bytes:
        return faults(data, direction) if is_damaging else data

    async with (
        node_harness() as harness,
        harness.bridge("tcp://127.0.0.1:0") as (address,),
        _relay(address, damage) as port,
        running(NODE, library, "tcp", "127.0.0.1", str(port)),
    ):
        publisher = await harness.graph.publisher("/question", "std_msgs/String")
        assert await publisher.wait_for_subscriber(60.0)
        sent = {"end"}
        for number in range(count):
            text = f"{number:04}".ljust(LONGEST_TEXT, "abcdefg"[number % 7])
            sent.add(text)
            before = len(harness.answers)
            publisher.publish(data=text)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(0.2):
                    while len(harness.answers) == before:
                        await asyncio.sleep(0.001)
        is_damaging = False
        async with asyncio.timeout(60.0):
            while "end" not in harness.answers:
                publisher.publish(data="end")
                await asyncio.sleep(0.05)
    assert faults.fault_count > 0
    assert set(harness.answers) <= sent
    assert len(set(harness.answers)) > 0.9 * count


async def test_messages_at_100_hz_do_not_use_up_memory(library: Path) -> None:
    async with (
        usb_board(PROGRAMS / "rate.py", library) as board,
        node_harness() as harness,
        harness.bridge(board.address),
    ):
        numbers: list[int] = []
        free: list[int] = []

        async def listen(topic: str, type_name: str, field: str, values: list[int]) -> None:
            async for message in harness.graph.messages(topic, type_name):
                values.append(getattr(message, field))

        tasks = [
            asyncio.ensure_future(listen("/stamps", "std_msgs/Header", "seq", numbers)),
            asyncio.ensure_future(listen("/memory", "std_msgs/UInt32", "data", free)),
        ]
        try:
            async with asyncio.timeout(effort(60, 180)):
                while len(free) < effort(4, 120):
                    await asyncio.sleep(0.01)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
    # None is lost or repeated.
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert len(numbers) >= effort(150, 5950)
    assert max(free[1:]) - min(free[1:]) < 1024, free


def _host_and_port(address: str) -> tuple[str, str]:
    host, _, port = address.removeprefix("tcp://").rpartition(":")
    return host, port


@contextlib.asynccontextmanager
async def _relay(address: str, manipulate: Manipulator) -> AsyncIterator[int]:
    """Relay the connections of a board to an address, with faults; yield the port."""
    host, port = _host_and_port(address)

    async def copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, direction: Direction) -> None:
        while data := await reader.read(4096):
            writer.write(manipulate(data, direction))
        writer.close()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        to_host_writer, to_host = await asyncio.open_connection(host, int(port))
        await asyncio.gather(
            copy(reader, to_host, Direction.FIRST_TO_SECOND),
            copy(to_host_writer, writer, Direction.SECOND_TO_FIRST),
            return_exceptions=True,
        )

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    async with server:
        yield server.sockets[0].getsockname()[1]
