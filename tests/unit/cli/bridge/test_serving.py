from __future__ import annotations

import pytest

from rostether.cli.bridge.serving import loopback_lines, read_links, read_web_boards, shortage_lines
from rostether.ros1.environment import RosEnvironment
from rostether.transports.address import TcpAddress, UdpAddress, WebAddress
from rostether.transports.address_parser import parse_address
from unit.cli.command_shell import LiveGraph, Shell

LOOPBACK = RosEnvironment.read({})
WIDE = RosEnvironment.read({"ROS_IP": "192.0.2.5"})


def test_a_listener_without_a_host_uses_the_given_hosts() -> None:
    hosts = WIDE.listen_hosts
    assert read_links("tcp://:11411") == [TcpAddress("127.0.0.1", 11411)]
    udp_links = read_links("udp://:11411?name=a", hosts)
    assert [link.host for link in udp_links if isinstance(link, UdpAddress)] == ["192.0.2.5", "127.0.0.1"]
    assert read_links("tcp://127.0.0.1:11411", hosts) == [TcpAddress("127.0.0.1", 11411)]
    assert read_links("/dev/ttyACM0", hosts) == [parse_address("/dev/ttyACM0")]


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
def test_one_line_names_what_listens_only_on_loopback(
    environment: RosEnvironment, addresses: list[str], count: int
) -> None:
    links = [link for address in addresses for link in read_links(address, environment.listen_hosts)]
    lines = loopback_lines(environment, links)
    assert len(lines) == count
    assert all("--listen 0.0.0.0" in line for line in lines)


def test_a_dashboard_serves_the_boards_of_its_pages() -> None:
    links = read_links("/dev/ttyACM0")
    assert read_web_boards(links, is_served=True, is_refused=False) is not None
    assert links == [parse_address("/dev/ttyACM0"), WebAddress()]
    links = read_links("web:?ns=lab")
    assert read_web_boards(links, is_served=True, is_refused=False) is not None
    assert links == [WebAddress(ns="lab")]
    for is_served, is_refused in ((True, True), (False, False)):
        links = []
        assert read_web_boards(links, is_served=is_served, is_refused=is_refused) is None
        assert links == []


def test_one_line_reports_too_many_open_files_for_the_connections(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("resource.getrlimit", lambda _: (4096, 4096))
    links = [parse_address(address) for address in ("/dev/ttyACM0", "tcp://:11411", "udp://:11411")]
    assert shortage_lines(None, links) == []
    assert shortage_lines(198, links) == []
    (line,) = shortage_lines(199, links)
    assert line.startswith("398 boards need up to 4108 open files, but the system permits 4096")


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["--probe", "ttyUSB0"], 1, "a USB id such as 1a86:7523"),
        (["--config", "/no/such/file"], 1, "/no/such/file: no such file"),
        (["/dev/ttyACM0?bad=1"], 1, "bad"),
        (["usb:/dev/ttyACM0"], 1, "unknown kind of link 'usb'"),
        (["web:"], 1, "web: needs --dashboard"),
        (["web:", "--dashboard", "--no-web-boards"], 1, "give only one of them"),
        (["/dev/ttyACM0", "--master", "nonsense"], 1, "nonsense"),
        (["/dev/ttyACM0", "--master", "http://a:1", "--master-port", "5"], 1, "give only one of them"),
        (["/dev/ttyACM0", "--msg-path", "/no/such/folder"], 1, "no such folder"),
    ],
)
def test_mistakes(graph: LiveGraph, shell: Shell, arguments: list[str], code: int, text: str) -> None:
    assert text in shell.failure("serve", *arguments, code=code)


def test_mistakes_of_a_command_line_that_scripts_write(shell: Shell) -> None:
    assert "__nmae" in shell.failure("serial-node", "__nmae:=x")
    assert "is not a ROS name" in shell.failure("serial-node", "__name:=a b")
