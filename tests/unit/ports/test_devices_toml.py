from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.mechanisms.toml_text import MAX_FILE_BYTES
from rostether.ports.board_identity import BoardIdentity
from rostether.ports.devices_toml import parse_devices_toml, read_devices_toml
from rostether.ports.settings import Access, DeviceMatch, DeviceSettings, DiscoverySettings, NameRule

FULL = """
[discovery]
probe = ["1A86:7523", "/dev/ttyUSB*"]
ignore = ["0403:6001"]

[defaults]
grace_s = 10
queue_depths = { "/cmd_vel" = 1 }

[devices.arm]
serial_number = "7583"
usb_id = "2341:0043"
baud = 115200
reset = false
namespace = "/lab"
remap = { chatter = "/talk" }
required_topics = ["/imu", "odom"]
queue_depths = { "/led" = 5 }

[devices.arm.access]
publish = { allow = ["/lab/*"], deny = ["/lab/secret"] }

[devices."lab/base"]
address = "192.168.1.20"
grace_s = 0
"""


def test_everything_that_can_be_set() -> None:
    book = parse_devices_toml(FULL)
    assert book.discovery == DiscoverySettings(probe=("1A86:7523", "/dev/ttyUSB*"), ignore=("0403:6001",))
    arm, base = book.devices
    assert arm == DeviceSettings(
        name="arm",
        match=DeviceMatch(serial_number="7583", usb_id="2341:0043"),
        baud=115200,
        reset=False,
        namespace="/lab",
        remap={"chatter": "/talk"},
        required_topics=("/imu", "odom"),
        access=Access(publish=NameRule(("/lab/*",), ("/lab/secret",))),
        queue_depths={"/cmd_vel": 1, "/led": 5},
        grace_s=10.0,
    )
    assert (base.name, base.grace_s, base.queue_depths) == ("lab/base", 0.0, {"/cmd_vel": 1})


def test_a_board_matches_by_all_keys_and_others_have_the_defaults() -> None:
    book = parse_devices_toml(FULL)
    arm = BoardIdentity(usb_id="2341:0043", serial_number="7583", port="/dev/ttyACM3")
    assert book.settings_matching(arm).name == "arm"
    other = BoardIdentity(usb_id="2341:0010", serial_number="7583")
    assert book.settings_matching(other) is book.defaults
    assert book.settings_matching(BoardIdentity(address="192.168.1.20")).name == "lab/base"
    assert book.settings_named("/lab/base") is book.devices[1]
    assert book.settings_named("leg") is None


def test_a_table_without_match_keys_is_for_links_with_its_name() -> None:
    book = parse_devices_toml('[devices.arm]\nbaud = 9600\n[devices."lab/leg"]\n[devices.a]\nport = "/x"')
    here = BoardIdentity(port="/dev/ttyUSB0")
    assert book.settings_for("arm", here).baud == 9600
    assert book.settings_for(None, here) is book.settings_for("other", here) is book.defaults
    assert book.unchosen([None, "other"]) == ["arm", "lab/leg"]
    assert book.unchosen(["/lab/leg", None, "~arm"]) == []


def test_a_port_is_found_by_its_link_and_by_a_pattern(tmp_path: Path) -> None:
    port, link = tmp_path / "ttyUSB0", tmp_path / "by-path-1"
    port.touch()
    link.symlink_to(port)
    for marked in (str(link), str(port), f"{tmp_path}/ttyUSB*", f"{tmp_path}/by-path-*"):
        book = parse_devices_toml(f'[devices.a]\nport = "{marked}"')
        assert book.settings_matching(BoardIdentity(port=str(port))).name == "a", marked
        assert book.settings_matching(BoardIdentity(port="/dev/null")).name is None
        assert book.settings_matching(BoardIdentity(address="10.0.0.1")).name is None


@pytest.mark.parametrize(
    ("text", "place", "says"),
    [
        ("[devices.a", "", "not TOML"),
        (f"a = {'9' * 5000}", "", "not TOML"),
        ("device = 1", "device", "unknown key; known: discovery, defaults, devices"),
        ("devices = 1", "devices", "must be a table, not 1"),
        ("[devices]\na = 1", "devices.a", "must be a table, not 1"),
        ("[[devices]]\na = 1", "devices", "must be a table, not [a table]"),
        ("[devices.a]\nport = {a = 1}", "devices.a.port", "not a table"),
        ("[devices.a]\nport = 2026-01-01", "devices.a.port", ", not 2026-01-01"),
        ("[devices.a]\nport = [true, 'x']", "devices.a.port", ", not [true, 'x']"),
        (
            '[devices.a]\nport = "/x"\nbaudrate = 9600',
            "devices.a.baudrate",
            "unknown key; known: serial_n",
        ),
        (
            '[devices.a]\nport = "/x"\nbaud = "fast"',
            "devices.a.baud",
            "whole number from 1 to 20000000, not 'f",
        ),
        ('[devices.a]\nport = "/x"\nbaud = true', "devices.a.baud", "not true"),
        ('[devices.a]\nport = "/x"\nbaud = 0', "devices.a.baud", "not 0"),
        ('[devices.a]\nport = "x"', "devices.a.port", "a path or pattern"),
        ('[devices.a]\nusb_id = "2341"', "devices.a.usb_id", "two groups of four hex digits"),
        ('[devices.a]\naddress = "robot"', "devices.a.address", "numeric address"),
        ("[devices.a]\nserial_number = 7", "devices.a.serial_number", "write a text, not 7"),
        ('[devices."a b"]\nport = "/x"', "devices.'a b'", "not a ROS name"),
        ('[devices.a]\nport = "/x"\nnamespace = "a b"', "devices.a.namespace", "not a ROS name"),
        ('[devices.a]\nport = "/x"\nreset = "no"', "devices.a.reset", "write true or false"),
        ('[devices.a]\nport = "/x"\nremap = { a = 1 }', "devices.a.remap.a", "write a ROS name"),
        ('[devices.a]\nport = "/x"\nrequired_topics = "/x"', "devices.a.required_topics", "a list in bra"),
        ('[devices.a]\nport = "/x"\nqueue_depths = { a = 0 }', "devices.a.queue_depths.a", "from 1 to"),
        ('[devices.a]\nport = "/x"\nlimits = 3', "devices.a.limits", "must be a table"),
        ('[devices.a]\nport = "/x"\nlimits.frames = 3', "devices.a.limits.frames", "known: frame_bytes"),
        ("[defaults]\nlimits.endpoints = 1.5", "defaults.limits.endpoints", "from 1 to 4096, not 1.5"),
        ("[defaults]\nlimits.messages_hz = 0", "defaults.limits.messages_hz", "from 1 to 1e+07, not 0"),
        ('[devices.a]\nport = "/x"\ngrace_s = nan', "devices.a.grace_s", "from 0 to 86400, not nan"),
        (
            '[devices.a]\nport = "/x"\naccess = { read = {} }',
            "devices.a.access.read",
            "known: publish, sub",
        ),
        (
            '[devices.a]\nport = "/x"\naccess.publish = { allow = ["imu"] }',
            "devices.a.access.publish.allow",
            'full names such as "/imu"',
        ),
        ('[defaults]\nport = "/x"', "defaults.port", "unknown key"),
        ('[discovery]\nprobe = ["ttyUSB0"]', "discovery.probe", "a USB id such as"),
        ('[devices.a]\nport = "/x"\n[devices.b]\nport = "/x"', "devices.b", "same keys as devices.a"),
    ],
)
def test_a_mistake_is_one_line_with_file_and_key(text: str, place: str, says: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_devices_toml(text, file="my.toml")
    line = str(caught.value)
    assert line.startswith(f"my.toml:{place}: " if place else "my.toml: ")
    assert says in line
    assert "\n" not in line


def test_a_missing_file_is_empty_unless_it_was_named(tmp_path: Path) -> None:
    path = tmp_path / "devices.toml"
    assert read_devices_toml(path).devices == ()
    with pytest.raises(ConfigError, match="no such file"):
        read_devices_toml(path, is_required=True)


def test_other_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "devices.toml"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigError, match="not UTF-8 text at byte 0"):
        read_devices_toml(path)
    path.write_bytes(b"#" * (MAX_FILE_BYTES + 1))
    with pytest.raises(ConfigError, match="longer than"):
        read_devices_toml(path)
    with pytest.raises(ConfigError, match="cannot read"):
        read_devices_toml(tmp_path)


def test_the_number_of_entries_is_limited() -> None:
    names = ", ".join(f'"/t{number}"' for number in range(1001))
    with pytest.raises(ConfigError, match="at most 1000"):
        parse_devices_toml(f'[devices.a]\nport = "/x"\nrequired_topics = [{names}]')


@pytest.mark.parametrize(
    ("rule", "name", "is_permitted"),
    [
        (NameRule(), "/anything", True),
        (NameRule(("/arm/*",)), "/arm/joint/1", True),
        (NameRule(("/arm/*",)), "/army", False),
        (NameRule(()), "/a", False),
        (NameRule(None, ("/rosout",)), "/rosout", False),
        (NameRule(("*",), ("/a*",)), "/ab", False),
    ],
)
def test_name_rules(rule: NameRule, name: str, is_permitted: bool) -> None:
    assert (rule.refusal(name) is None) is is_permitted


def test_limits_of_a_board_are_added_to_those_of_all() -> None:
    book = parse_devices_toml(
        "[defaults.limits]\nendpoints = 9\nmessages_hz = 0.5e3\n"
        '[devices.a]\nport = "/x"\nlimits = { endpoints = 3, topic_bytes = 8192, service_s = 1.5 }'
    )
    assert book.defaults.limits == {"endpoints": 9, "messages_hz": 500.0}
    assert book.devices[0].limits == {
        "endpoints": 3,
        "messages_hz": 500.0,
        "queue_bytes": 8192,
        "service_timeout_s": 1.5,
    }
