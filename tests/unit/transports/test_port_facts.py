from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rostether.transports.port_facts import group_of, near_names, read_port_facts
from rostether.transports.serial_port import SerialPort


def test_a_port_that_does_not_exist_has_ports_with_similar_names() -> None:
    ports = [SerialPort(path, "Arduino Uno") for path in ("/dev/ttyACM0", "/dev/ttyUSB3")]
    facts = read_port_facts("/dev/ttyACM9", lambda: ports)
    assert not facts.exists
    assert "/dev/ttyACM0 (Arduino Uno)" in facts.near
    assert facts.others == ("/dev/ttyACM0 (Arduino Uno)", "/dev/ttyUSB3 (Arduino Uno)")


def test_links_beside_a_port_are_near_too(tmp_path: Path) -> None:
    (tmp_path / "board").touch()
    (tmp_path / "unlike").touch()
    assert near_names(str(tmp_path / "bord"), []) == [str(tmp_path / "board")]
    assert near_names("/nowhere/at/all", []) == []


def test_a_board_on_usb_is_not_at_a_port_of_the_mainboard() -> None:
    assert "/dev/ttyS0" not in near_names("/dev/ttyACM0", ["/dev/ttyS0"])
    assert near_names("/dev/ttyS00", ["/dev/ttyS0"])[0] == "/dev/ttyS0"


def test_a_file_is_not_a_device(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.touch()
    facts = read_port_facts(str(path), list)
    assert facts.exists
    assert not facts.is_device


def test_a_port_that_this_process_has_open() -> None:
    master, slave = os.openpty()
    facts = read_port_facts(os.ttyname(slave), list)
    assert facts.is_device
    assert facts.may_open
    assert facts.holders == ()
    os.close(slave)
    os.close(master)


def test_the_group_that_may_use_a_port(tmp_path: Path) -> None:
    import grp

    path = tmp_path / "port"
    path.touch()
    gid = next((each.gr_gid for each in grp.getgrall() if each.gr_name == "dialout"), None)
    if os.getuid() != 0 or gid is None:
        pytest.skip("only root gives files to other groups")
    os.chown(path, 0, gid)
    path.chmod(0o660)
    assert group_of(str(path)) == "dialout"
    path.chmod(0o600)
    assert group_of(str(path)) is None
    assert group_of(str(tmp_path / "nothing")) == "dialout"


ASK = """
import difflib, grp, os, sys
from rostether.transports.port_facts import read_port_facts
os.setgid(65534)
os.setuid(65534)
print(read_port_facts(sys.argv[1], list).may_open)
"""


def test_a_missing_permission_is_reported() -> None:
    if os.getuid() != 0:
        pytest.skip("only root becomes somebody else")
    master, slave = os.openpty()
    path = os.ttyname(slave)
    Path(path).chmod(0o600)
    try:
        answer = subprocess.run(
            [sys.executable, "-c", ASK, path],
            capture_output=True,
            text=True,
            check=False,
        )
        assert answer.stdout.strip() == "False", answer.stderr
    finally:
        os.close(slave)
        os.close(master)
