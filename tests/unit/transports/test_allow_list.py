from __future__ import annotations

import pytest

from rostether.transports.allow_list import AllowList


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
        (["0.0.0.0/0"], "::1", False),
        (["0.0.0.0/0"], "not an address", False),
    ],
)
def test_allow(networks: list[str], host: str, allowed: bool) -> None:
    assert AllowList(networks).allows(host) is allowed
