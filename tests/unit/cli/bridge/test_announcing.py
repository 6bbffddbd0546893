from __future__ import annotations

import pytest

from rostether.cli.bridge.announcing import announced, check_mdns, network_listeners
from rostether.errors import ConfigError, TransportOpenError
from rostether.graph.ports import Level
from rostether.transports import mdns
from rostether.transports.address import TcpAddress
from unit.bridge.doubles import RecordingReporter
from waiting import until


def test_only_listeners_that_the_network_reaches_are_announced() -> None:
    listening_on = ["tcp://127.0.0.1:11411", "udp://0.0.0.0:11411", "tcp://0.0.0.0:11412", "tcp://[::1]:1"]
    assert network_listeners(listening_on) == [TcpAddress("0.0.0.0", 11412)]


def test_zeroconf_is_asked_for_only_when_it_is_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    assert check_mdns(is_wanted=None)
    assert check_mdns(is_wanted=True)
    assert not check_mdns(is_wanted=False)
    monkeypatch.setattr("rostether.cli.bridge.announcing.find_spec", lambda _name: None)
    assert not check_mdns(is_wanted=None)
    with pytest.raises(ConfigError, match=r"pip install 'rostether\[mdns\]'"):
        check_mdns(is_wanted=True)


async def test_a_missing_listener_is_reported_only_with_the_option() -> None:
    reporter = RecordingReporter()
    async with announced(["tcp://127.0.0.1:11411"], reporter, is_wanted=None):
        pass
    assert reporter.texts == []
    async with announced(["tcp://127.0.0.1:11411"], reporter, is_wanted=True):
        pass
    assert len(reporter.having("--listen 0.0.0.0")) == 1


class FakeAnnouncement:
    closed = 0
    name = "rostether on lab"

    @classmethod
    async def start(cls, host: str, port: int) -> FakeAnnouncement:
        if port == 1:
            raise TransportOpenError("mDNS: no network")
        return cls()

    async def close(self) -> None:
        type(self).closed += 1


async def test_listeners_are_announced_while_boards_are_served(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mdns, "ListenerAnnouncement", FakeAnnouncement)
    reporter = RecordingReporter()
    async with announced(["tcp://0.0.0.0:1", "tcp://192.0.2.5:11411"], reporter, is_wanted=None):
        await until(lambda: reporter.having("Announced by mDNS"), "the announcement")
    assert FakeAnnouncement.closed == 1
    assert reporter.lines[0][:2] == (
        Level.WARN,
        "mDNS: no network; configure this machine's address on the boards instead",
    )
    assert "port 11411" in reporter.texts[1]
