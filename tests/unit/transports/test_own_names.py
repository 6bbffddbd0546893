"""The Host headers that mean this machine."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from rostether.transports import own_names
from rostether.transports.own_names import OwnNames, is_own_address


@pytest.fixture(autouse=True)
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A machine named robot on the network lab.example."""
    (tmp_path / "hosts").write_text(
        "127.0.0.1 localhost gate  # comment\n10.0.0.5 robot.fleet.example robot arm\n"
        "10.0.0.9 other.example\n"
    )
    (tmp_path / "resolv.conf").write_text("nameserver 10.0.0.1\nsearch lab.example\n")
    monkeypatch.setattr(own_names, "_HOSTS", tmp_path / "hosts")
    monkeypatch.setattr(own_names, "_RESOLVER", tmp_path / "resolv.conf")
    monkeypatch.setattr(socket, "gethostname", lambda: "Robot")
    own_names._machine_names.cache_clear()
    yield
    own_names._machine_names.cache_clear()


@pytest.mark.parametrize(
    "host",
    [
        *(
            "localhost",
            "localhost:11311",
            "LOCALHOST.",
            "x.localhost",
            "127.0.0.1:11311",
            "10.1.2.3",
            "[::1]:80",
            "::1",
        ),
        *("robot", "ROBOT:11311", "robot.", "robot.local", "robot.local:1", "robot.lab.example", "gate"),
        *("robot.fleet.example:1", "arm", "given.example", "given.example:11311"),
    ],
)
def test_names_of_this_machine(host: str) -> None:
    assert OwnNames(["Given.example", ""]).include(host)


@pytest.mark.parametrize(
    "host",
    [
        *(
            "",
            ":80",
            "evil.example",
            "evil.example:11311",
            "robot.evil.example",
            "other.example",
            "10.0.0.5.evil.example",
        ),
        *(
            "localhost.evil.example",
            "127.0.0.1.nip.io:11311",
            "[::1",
            "robot:80:80",
            "lab.example",
            "robot@evil",
        ),
    ],
)
def test_names_of_others(host: str) -> None:
    assert not OwnNames().include(host)


def test_a_machine_without_these_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("_HOSTS", "_RESOLVER"):
        monkeypatch.setattr(own_names, name, tmp_path / "none")
    own_names._machine_names.cache_clear()
    assert OwnNames().include("robot")
    assert not OwnNames().include("arm")


@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0", "::1"])
def test_addresses_of_this_machine(host: str) -> None:
    assert is_own_address(host)


@pytest.mark.parametrize("host", ["192.0.2.1", "2001:db8::1", "fe80::1"])
def test_addresses_of_others(host: str) -> None:
    assert not is_own_address(host)
