"""The Arduino platform headers: ports of any class, and network sketches with the real bridge.

The network sketches run on Linux, with clients that have Arduino's interfaces on the system's sockets.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import struct
import subprocess
import time
from pathlib import Path

import pytest

from firmware.platforms.node_harness import TIMEOUT_S, node_harness
from firmware.platforms.programs import EXTRAS, compile_program, running
from rostether.rosserial.frame import encode_frame
from unit.bridge.lateness import lateness
from waiting import until

pytestmark = pytest.mark.gcc

ON_HOST = EXTRAS / "arduino_on_host"
SANITIZED = ("g++", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-DARDUINO=10819")


@pytest.fixture(scope="session")
def tcp_sketch(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The node with ROSSERIAL_ARDUINO_TCP."""
    return _compile("network_node.cpp", library, tmp_path_factory, "-DROSSERIAL_ARDUINO_TCP")


@pytest.fixture(scope="session")
def udp_sketch(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The node with ROSSERIAL_ARDUINO_UDP."""
    return _compile("network_node.cpp", library, tmp_path_factory, "-DROSSERIAL_ARDUINO_UDP")


def _compile(source: str, library: Path, folders: pytest.TempPathFactory, *flags: str) -> Path:
    output = folders.mktemp("arduino") / Path(source).stem
    return compile_program([*SANITIZED, *flags, f"-I{ON_HOST}"], [ON_HOST / source], library, output)


async def test_an_esp32_uses_the_network_without_a_switch(
    library: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """On these boards, the established library uses the network without a switch."""
    program = tmp_path_factory.mktemp("arduino") / "esp32"
    source = ON_HOST / "network_node.cpp"
    compile_program(["g++", "-DARDUINO=10819", "-DESP32", f"-I{ON_HOST}"], [source], library, program)
    async with (
        node_harness() as harness,
        harness.bridge("tcp://127.0.0.1:0") as (address,),
        running(program, address.rpartition(":")[2]),
    ):
        await harness.exchange_messages()


def test_ports_of_any_class(library: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    completed = subprocess.run([_compile("serial_ports.cpp", library, tmp_path_factory)], check=False)
    assert completed.returncode == 0, f"check {completed.returncode} of serial_ports.cpp failed"


async def test_tcp_exchanges_messages_and_reconnects_within_two_seconds(tcp_sketch: Path) -> None:
    async with node_harness() as harness, contextlib.AsyncExitStack() as node:
        async with harness.bridge("tcp://127.0.0.1:0") as (address,):
            await node.enter_async_context(running(tcp_sketch, address.rpartition(":")[2]))
            await harness.exchange_messages()
        # Long enough for the longest pause between its attempts.
        await asyncio.sleep(2.0)
        began_s = time.monotonic()
        async with harness.bridge(address):
            async with lateness() as late:
                await harness.wait_for_counts(1)
            assert time.monotonic() - began_s - late.total_s < 2.0
            await harness.exchange_messages()


async def test_a_connection_to_a_host_that_is_no_longer_reachable_is_replaced(
    tcp_sketch: Path, linux_program: Path
) -> None:
    """A failed network does not end the connection; the host only stops answering."""
    request_topics = encode_frame(0, b"")

    async def time_until_second_connection(program: Path, own_host: str) -> float:
        began_s: list[float] = []

        async def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            began_s.append(time.monotonic())
            writer.write(request_topics)
            while await reader.read(65536):
                pass
            writer.close()

        async with await asyncio.start_server(accept, "127.0.0.1", 0) as server:
            port = server.sockets[0].getsockname()[1]
            async with running(program, f"{own_host}{port}"):
                await until(lambda: len(began_s) == 2, "its second connection")
        return began_s[1] - began_s[0]

    async with lateness() as late:
        times_s = await asyncio.gather(
            time_until_second_connection(tcp_sketch, ""),
            time_until_second_connection(linux_program, "127.0.0.1:"),
        )
    assert 8.0 < min(times_s) <= max(times_s) < 12.0 + late.total_s


async def test_udp_exchanges_messages(udp_sketch: Path) -> None:
    async with (
        node_harness() as harness,
        harness.bridge("udp://127.0.0.1:0") as (address,),
        running(udp_sketch, address.rpartition(":")[2]),
    ):
        await harness.exchange_messages()


async def test_udp_sends_whole_frames_and_receives_only_from_the_host(udp_sketch: Path) -> None:
    request_topics = encode_frame(0, b"")
    with _udp_socket() as host, _udp_socket() as other:
        async with running(udp_sketch, str(host.getsockname()[1])):
            # Its announcements, every 2.2 s: seven topic infos (two for a service), and the time request.
            first, board = await asyncio.to_thread(host.recvfrom, 2048)
            datagrams = [first] + [await asyncio.to_thread(host.recv, 2048) for _ in range(7)]
            for datagram in datagrams:
                sync, version, length = struct.unpack_from("<BBH", datagram)
                assert (sync, version, length + 8) == (0xFF, 0xFE, len(datagram))
            host.settimeout(0.3)
            for _ in range(10):
                other.sendto(request_topics, board)
                # On a busy machine, it may have announced itself again in this time.
                if not await asyncio.to_thread(_receive_all, host):
                    break
            else:
                pytest.fail("each request of another program was answered")
            host.settimeout(TIMEOUT_S)
            host.sendto(request_topics, board)
            assert await asyncio.to_thread(host.recv, 2048)


def _receive_all(receiver: socket.socket) -> int:
    """Receive until nothing arrives for the socket's time limit; return the number of datagrams."""
    count = 0
    with contextlib.suppress(TimeoutError):
        while receiver.recv(2048):
            count += 1
    return count


def _udp_socket() -> socket.socket:
    udp_socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    udp_socket.bind(("127.0.0.1", 0))
    udp_socket.settimeout(TIMEOUT_S)
    return udp_socket
