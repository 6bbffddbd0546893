from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.transports.allow_list import AllowList, check_networks


@pytest.mark.parametrize(
    ("networks", "host", "allowed"),
    [
        ([], "203.0.113.9", True),
        ([], "", True),
        (["192.168.1.0/24"], "192.168.1.77", True),
        (["192.168.1.0/24"], "192.168.2.77", False),
        (["192.168.1.5/24"], "192.168.1.77", True),
        (["10.0.0.7", "10.0.0.9"], "10.0.0.9", True),
        (["10.0.0.7"], "10.0.0.8", False),
        (["192.168.1.0/24"], "::ffff:192.168.1.77", True),
        (["fe80::/10"], "fe80::1%eth0", True),
        (["fe80::/10"], "192.168.1.77", False),
        (["0.0.0.0/0"], "2001:db8::1", False),
        (["10.0.0.7"], "127.0.0.1", True),
        (["10.0.0.7"], "127.1.2.3", True),
        (["10.0.0.7"], "::1", True),
        (["10.0.0.7"], "::ffff:127.0.0.1", True),
        (["2001:db8::/32"], "2001:db8:1::9", True),
        (["0.0.0.0/0"], "not an address", False),
    ],
)
def test_allow(networks: list[str], host: str, allowed: bool) -> None:
    assert AllowList(networks).allows(host) is allowed


def test_a_connection_between_two_ends_of_one_address_is_local() -> None:
    allow = AllowList(["10.0.0.7"])
    assert allow.allows_connection("192.0.2.5", "192.0.2.5")
    assert not allow.allows_connection("192.0.2.5", "192.0.2.6")


def test_networks_are_checked_by_whoever_gives_them() -> None:
    assert check_networks(["10.0.0.0/8", "fe80::/10"], "--allow") == ("10.0.0.0/8", "fe80::/10")
    with pytest.raises(ConfigError, match=r"--allow: 'lab' is not a network; write for example 192\.168"):
        check_networks(["lab"], "--allow")
