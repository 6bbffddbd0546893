"""--allow on the command line, for listeners of boards and for the graph; this machine is always allowed."""

from __future__ import annotations

import pytest

from interop.ros1_peers import free_port
from programs import started
from rostether import Device
from rostether.cli.bridge.serving import read_links
from rostether.transports.address import TcpAddress, UdpAddress

NETWORKS = ("10.0.0.0/8", "fd00::/8")


def test_listeners_use_it_unless_their_address_has_networks() -> None:
    assert read_links("tcp://:1", allowed=NETWORKS) == [TcpAddress("127.0.0.1", 1, allow=NETWORKS)]
    assert read_links("udp://0.0.0.0:1", allowed=NETWORKS) == [UdpAddress("0.0.0.0", 1, allow=NETWORKS)]
    own = "tcp://0.0.0.0:1?allow=192.168.7.0/24"
    assert read_links(own, allowed=NETWORKS) == [TcpAddress("0.0.0.0", 1, allow=("192.168.7.0/24",))]
    assert read_links("tcp://a:1?connect=yes", allowed=NETWORKS) == [TcpAddress("a", 1, connect=True)]


@pytest.mark.parametrize(
    "command",
    [
        ("serve", "tcp://:0"),
        ("core", "--port", "0"),
        ("serial-node", "tcp", "0"),
        ("topic", "echo", "/a"),
        ("topic", "pub", "/a", "std_msgs/Empty"),
        ("topic", "hz", "/a"),
        ("service", "call", "/a"),
        ("monitor",),
    ],
    ids=" ".join,
)
async def test_no_network_is_one_line(command: tuple[str, ...]) -> None:
    async with started(*command, "--allow", "10.0.0.0/8", "--allow", "lab") as process:
        text = await process.finish()
    assert text.strip() == (
        "rostether: error: --allow: 'lab' is not a network; write for example 192.168.1.0/24 or 10.0.0.7"
    )
    assert process.process.returncode == 1


async def test_boards_and_nodes_of_this_machine_are_always_served() -> None:
    board_port, port = free_port(), free_port()
    words = ("serve", f"tcp://:{board_port}", "--listen", "0.0.0.0", "--allow", "192.0.2.0/24")
    async with started(*words, ROS_MASTER_URI=f"http://localhost:{port}") as serve:
        await serve.wait_for("Waiting for boards")
        async with Device(f"tcp://127.0.0.1:{board_port}") as device:
            device.publisher("count", "std_msgs/UInt32")
            await device.wait_connected(60.0)
        assert "refused" not in serve.text
