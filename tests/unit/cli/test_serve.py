from __future__ import annotations

import re
import signal
import sys
from pathlib import Path

import pytest

from rostether.cli.serving import loopback_lines, read_links
from rostether.device import Device
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.registrations import Kind
from rostether.transports.address import TcpAddress, UdpAddress, parse_address
from unit.cli.processes import read_until, started
from unit.cli.shell import LiveGraph, Shell

LOOPBACK = RosEnvironment.read({})
WIDE = RosEnvironment.read({"ROS_IP": "192.0.2.5"})


class Board:
    """A device that counts, plugged in at an address."""

    def __init__(self, graph: LiveGraph, address: str) -> None:
        self._graph = graph

        async def plug_in() -> Device:
            device = Device(address)
            device.publisher("count", "std_msgs/UInt16")
            device.subscriber("led", "std_msgs/Bool", lambda _message: None)
            await device.__aenter__()
            return device

        self.device = graph.do(plug_in())

    def close(self) -> None:
        self._graph.do(self.device.close())


def serial_node_of(graph: LiveGraph) -> list[str]:
    return sorted(graph.master.api.registrations.nodes)


def test_serve_a_board_until_it_is_told_to_end(graph: LiveGraph) -> None:
    command = ("serve", "tcp://:0?name=arm", "--ns-per-board")
    with started(graph.uri, *command) as process:
        lines = read_until(process, "Waiting for boards on")
        assert "Joining the ROS master at" in lines[0]
        assert any("--listen 0.0.0.0 lets boards on the network in" in line for line in lines)
        board = Board(graph, lines[-1].rpartition(" ")[2])
        lines = read_until(process, "Setup subscriber on led [std_msgs/Bool]")
        assert any(
            re.fullmatch(r"\[INFO\] \[\d+\.\d{6}\]: /arm: Setup publisher on count \[std_msgs/UInt16\]", line)
            for line in lines
        )
        graph.wait_until(lambda: "/arm/led" in graph.master.api.registrations.keys(Kind.SUBSCRIBER))
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
        assert process.returncode == 130
        assert serial_node_of(graph) == []
        board.close()


def test_serial_node_as_scripts_start_it(graph: LiveGraph) -> None:
    graph.do(graph.node("setter").set_param("/lab/opencr/tcp_port", 0))
    command = ("serial-node", "tcp", "__name:=opencr", "__ns:=/lab", "led:=lamp")
    with started(graph.uri, *command) as process:
        lines = read_until(process, "Waiting for boards on")
        assert re.fullmatch(r"\[INFO\] \[\d+\.\d{6}\]: ROS Serial Python Node", lines[0])
        board = Board(graph, lines[-1].rpartition(" ")[2])
        lines = read_until(process, "Setup subscriber on led [std_msgs/Bool]")
        assert any("]: Note: publish buffer size is" in line for line in lines)
        graph.wait_until(lambda: "/lab/opencr" in serial_node_of(graph))
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=20)
        assert process.returncode == 0
        board.close()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_a_pseudo_terminal_for_a_simulator(graph: LiveGraph, tmp_path: Path) -> None:
    link = tmp_path / "board"
    with started(graph.uri, "serve", f"pty:{link}") as process:
        read_until(process, f"Connecting to pty:{link}")
        board = Board(graph, str(link))
        read_until(process, "/board: Setup publisher on count [std_msgs/UInt16]")
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=20)
        assert process.returncode == 0
        assert not link.is_symlink()
        board.close()


def test_a_listener_without_a_host_listens_where_the_environment_lets_us() -> None:
    assert read_links("tcp://:11411", LOOPBACK) == [TcpAddress("127.0.0.1", 11411)]
    hosts = [link.host for link in read_links("udp://:11411?name=a", WIDE) if isinstance(link, UdpAddress)]
    assert hosts == ["192.0.2.5", "127.0.0.1"]
    assert read_links("tcp://127.0.0.1:11411", WIDE) == [TcpAddress("127.0.0.1", 11411)]
    assert read_links("/dev/ttyACM0", WIDE) == [parse_address("/dev/ttyACM0")]


@pytest.mark.parametrize(
    ("environment", "addresses", "count"),
    [
        (LOOPBACK, ["/dev/ttyACM0"], 0),
        (LOOPBACK, ["tcp://:11411", "udp://:11411"], 2),
        (LOOPBACK, ["tcp://0.0.0.0:11411"], 0),
        (WIDE, ["tcp://:11411"], 0),
        (RosEnvironment.read({"ROS_MASTER_URI": "http://192.0.2.1:11311"}), ["/dev/ttyACM0"], 1),
    ],
)
def test_one_line_says_what_is_on_loopback_only(
    environment: RosEnvironment, addresses: list[str], count: int
) -> None:
    links = [link for address in addresses for link in read_links(address, environment)]
    lines = loopback_lines(environment, links)
    assert len(lines) == count
    assert all("--listen 0.0.0.0" in line for line in lines)


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        ([], 2, "ADDRESS"),
        (["/dev/ttyACM0?bad=1"], 1, "bad"),
        (["usb:/dev/ttyACM0"], 1, "unknown kind of link 'usb'"),
        (["/dev/ttyACM0", "--master", "nonsense"], 1, "nonsense"),
        (["/dev/ttyACM0", "--master", "http://a:1", "--master-port", "5"], 1, "give one of them"),
        (["/dev/ttyACM0", "--msg-path", "/no/such/folder"], 1, "no such folder"),
    ],
)
def test_mistakes(graph: LiveGraph, shell: Shell, arguments: list[str], code: int, text: str) -> None:
    assert text in shell.failure("serve", *arguments, code=code)
