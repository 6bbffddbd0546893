from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.platform.boot.robot_file import (
    Machine,
    MachineKind,
    Part,
    RobotFile,
    parse_robot_file,
)

COMMANDS = {"serve", "core", "role", "dashboard"}


def parse(text: str) -> RobotFile:
    return parse_robot_file(text, "robot.toml", COMMANDS)


def test_a_robot() -> None:
    robot = parse(
        """
        name = "r1"
        master = "http://base:11311"
        address = "10.0.0.2"
        [environment]
        ROS_DOMAIN_ID = "3"
        [parts]
        core = "rostether core"
        boards = "serve '/dev/my board'"
        """
    )
    assert robot.parts == (Part("core", ("core",)), Part("boards", ("serve", "/dev/my board")))
    assert robot.environment == {
        "ROS_DOMAIN_ID": "3",
        "PLATFORM_NAME": "r1",
        "ROS_MASTER_URI": "http://base:11311",
        "ROS_IP": "10.0.0.2",
    }


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("name = ", "not TOML"),
        ("nmae = 'x'", "robot.toml:nmae: unknown key; known: name, master, address,"),
        (
            "interface = 'wlan0,eth0'\n[parts]\na = 'core'",
            "robot.toml:interface: write the name of a",
        ),
        (
            "interface = '10.0.0.2'\n[parts]\na = 'core'",
            "write the name of a network interface",
        ),
        ("name = 3", "robot.toml:name: write one line of text in quotes, not 3"),
        ("", r"no parts; add a table \[parts\]"),
        ("parts = 3", "robot.toml:parts: must be a table, not 3"),
        ("[parts]\na = 'rm -rf x'", "robot.toml:parts.a: must be a rostether command"),
        ("[parts]\na = ''", "robot.toml:parts.a: must be a rostether command"),
        ("[parts]\n\"a\\u001b[31m\" = 'core'", "parts: a name has 1 to 64 printable characters"),
        (
            "[environment]\n\"A=B\" = '1'\n[parts]\na = 'core'",
            "environment.'A=B': not the name of a variable",
        ),
        ('[parts]\na = "serve \'"', "robot.toml:parts.a: must be a command line: No closing quotation"),
        (
            "[parts]\n" + "".join(f"p{n} = 'core'\n" for n in range(65)),
            "at most 64 parts are allowed",
        ),
    ],
)
def test_what_is_wrong_is_named_in_one_line(text: str, reason: str) -> None:
    with pytest.raises(ConfigError, match=reason) as error:
        parse(text)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("kind", MachineKind)
def test_the_file_of_a_machine_can_be_read(kind: MachineKind) -> None:
    # JSON leaves DEL unescaped, and writes the emoji as two surrogate escapes; TOML allows neither.
    name = 'my "robot" \N{ROBOT FACE}\x7f'
    machine = Machine(kind, name, "base", "10.0.0.2", "wlan0", ["sim:my sketch"], {"two words": "role x"})
    robot = parse(machine.text)
    assert robot.name == name
    assert robot.environment["ROSTETHER_INTERFACE"] == "wlan0"
    names = [part.name for part in robot.parts]
    assert ("core" in names) == (kind is not MachineKind.ROBOT)
    assert (Part("boards", ("serve", "sim:my sketch")) in robot.parts) == (kind is not MachineKind.BASE)
    assert ("# --allow 192.168.1.0/24 to both" in machine.text) == ("--listen 0.0.0.0" in machine.text)
    assert names[-1] == "two words"
    assert robot.environment.get("ROS_MASTER_URI") == (
        "http://base:11311" if kind is MachineKind.ROBOT else None
    )
