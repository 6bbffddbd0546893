from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import fields

from rostether.bridge.settings import DEFAULT_SETTINGS, BridgeSettings
from rostether.cli.bridge.options import (
    BRIDGE_LIMITS,
    GRAPH_LIMITS,
    read_devices,
    read_graph_limits,
    read_limits,
    unchosen_lines,
)
from rostether.errors import ConfigError
from rostether.ports.devices_toml import Limit
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.transports.address_parser import parse_address
from unit.cli.command_shell import Shell

DOCUMENTED = (Path(__file__).parents[4] / "docs/reference/limits.md").read_text()


def test_the_users_own_file_is_read_unless_another_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert read_devices(None, ()).devices == ()
    own = tmp_path / "rostether" / "devices.toml"
    own.parent.mkdir()
    own.write_text('[devices.arm]\nusb_id = "2341:0043"\n')
    assert [device.name for device in read_devices(None, ()).devices] == ["arm"]
    other = tmp_path / "other.toml"
    other.write_text("")
    assert read_devices(other, ()).devices == ()
    own.write_text("nonsense = 1")
    with pytest.raises(ConfigError, match=r"devices\.toml:nonsense: unknown key"):
        read_devices(None, ())


def test_ports_to_probe_are_added_to_those_of_the_file(tmp_path: Path) -> None:
    file = tmp_path / "devices.toml"
    file.write_text('[discovery]\nprobe = ["all"]\nignore = ["0403:6001"]\n')
    discovery = read_devices(file, ["1a86:7523"]).discovery
    assert discovery.probe == ("all", "1a86:7523")
    assert discovery.ignore == ("0403:6001",)


def test_settings_that_no_board_can_have_are_reported(tmp_path: Path) -> None:
    file = tmp_path / "devices.toml"
    file.write_text("[devices.arm]\nbaud = 9600\n")
    book = read_devices(file, ())
    (line,) = unchosen_lines(book, [parse_address("/dev/ttyUSB0?name=leg"), parse_address("/dev/ttyS0")])
    assert "devices.arm matches no board" in line
    assert "?name=arm to an ADDRESS" in line
    assert unchosen_lines(book, [parse_address("/dev/ttyUSB0?name=arm")]) == []


def test_nothing_given_is_the_default() -> None:
    assert read_limits(()) == (DEFAULT_SETTINGS, DEFAULT_GRAPH_LIMITS)
    assert read_graph_limits(()) == DEFAULT_GRAPH_LIMITS


@pytest.mark.parametrize(
    ("limits", "defaults"), [(BRIDGE_LIMITS, DEFAULT_SETTINGS), (GRAPH_LIMITS, DEFAULT_GRAPH_LIMITS)]
)
def test_every_limit_is_a_setting_documented_and_its_default_is_permitted(
    limits: dict[str, Limit], defaults: BridgeSettings | GraphLimits
) -> None:
    names = {each.name for each in fields(defaults)}
    for name, limit in limits.items():
        assert limit.setting in names
        default = getattr(defaults, limit.setting)
        assert default is None or limit.lowest <= default <= limit.highest
        read_limits([f"{name}={limit.highest:.10g}"])
        assert f"`{name}`" in DOCUMENTED


def test_every_limit_of_the_graph_can_be_set() -> None:
    assert {limit.setting for limit in GRAPH_LIMITS.values()} == {each.name for each in fields(GraphLimits)}


def test_limits_are_read() -> None:
    settings, graph = read_limits(["frame-bytes=4096", "grace-s=1.5", "connections=3", "xmlrpc-bytes=65536"])
    assert (settings.frame_bytes, settings.grace_s, settings.connections) == (4096, 1.5, 3)
    assert graph.body_bytes == 65536
    assert read_graph_limits(["header-s=2.5"]).header_s == 2.5


def test_a_master_alone_has_no_limits_of_boards() -> None:
    with pytest.raises(ConfigError, match="frame-bytes=64: write NAME=VALUE, where NAME is one of xmlrpc-"):
        read_graph_limits(["frame-bytes=64"])


@pytest.mark.parametrize(
    "text", ["frame-bytes", "frames=1", "frame-bytes=65536", "endpoints=1.5", "grace-s=nan", "endpoints=x"]
)
def test_what_makes_no_sense_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        read_limits([text])
    assert str(caught.value).startswith(f"--limit {text}: ")
    assert "\n" not in str(caught.value)


def test_a_token_without_web_clients_is_refused(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    line = shell.failure("serve", "--token", "secret", "tcp://:0", code=2)
    assert line == "--token is for web clients; add --dashboard, --foxglove or --rosbridge"
    # In the environment, it is for all commands.
    monkeypatch.setenv("ROSTETHER_TOKEN", "secret")
    assert "no serial port" in shell.failure("serve", "/dev/ttyACMO")
