from __future__ import annotations

from pathlib import Path

import pytest

from rostether.cli.bridge.device_options import read_devices, unchosen_lines
from rostether.errors import ConfigError
from rostether.transports.address import parse_address


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
