from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rostether.transports.port_holders import Holder, find_holders, find_listener, is_character_device

HOLD = "import sys; held = open(sys.argv[1]); print(flush=True); sys.stdin.read()"
LISTEN = """
import socket, sys
server = socket.create_server(("127.0.0.1", 0))
print(server.getsockname()[1], flush=True)
sys.stdin.read()
"""
MAKE_TERMINAL = """
import os, sys
master, slave = os.openpty()
print(os.ttyname(slave), flush=True)
sys.stdin.read()
"""


@pytest.fixture
def pty() -> Iterator[str]:
    master, slave = os.openpty()
    yield os.ttyname(slave)
    os.close(slave)
    os.close(master)


class Peer:
    """Another process."""

    def __init__(self, program: str, *arguments: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-c", program, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        self.reported = self._process.stdout.readline().strip()
        self.pid = self._process.pid

    def end(self) -> None:
        self._process.communicate("", timeout=60)


def test_the_holder_of_a_port_is_named(pty: str) -> None:
    peer = Peer(HOLD, pty)
    try:
        (holder,) = find_holders(pty)
        assert holder.pid == peer.pid
        assert holder.name.startswith("python")
        assert " " not in holder.name
        assert str(holder).endswith(f"(PID {peer.pid})")
    finally:
        peer.end()
    assert find_holders(pty) == []


def test_a_script_is_named_by_its_file(tmp_path: Path, pty: str) -> None:
    script = tmp_path / "serial_node.py"
    script.write_text(HOLD)
    with subprocess.Popen(
        [sys.executable, str(script), pty], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout is not None
        other.stdout.readline()
        (holder,) = find_holders(pty)
        other.communicate()
    assert holder.name.endswith(" serial_node.py")


def test_this_process_is_not_another_program(pty: str) -> None:
    descriptor = os.open(pty, os.O_RDWR | os.O_NOCTTY)
    assert find_holders(pty) == []
    os.close(descriptor)


def test_the_simulator_that_made_a_terminal_is_not_a_competitor() -> None:
    peer = Peer(MAKE_TERMINAL)
    try:
        assert find_holders(peer.reported) == []
    finally:
        peer.end()


def test_the_listener_of_a_port_is_named() -> None:
    peer = Peer(LISTEN)
    try:
        holder = find_listener(int(peer.reported))
        assert holder is not None
        assert holder.pid == peer.pid
    finally:
        peer.end()
    with socket.create_server(("127.0.0.1", 0)) as ours:
        assert find_listener(ours.getsockname()[1]) is None


def test_what_is_a_device(pty: str) -> None:
    assert is_character_device(pty)
    assert not is_character_device(__file__)
    assert not is_character_device("/nowhere")
    assert str(Holder(7, "screen")) == "screen (PID 7)"


@pytest.mark.skipif(sys.platform != "linux", reason="device numbers differ")
def test_every_process_has_dev_null_open_so_that_it_is_not_a_port() -> None:
    assert not is_character_device("/dev/null")
