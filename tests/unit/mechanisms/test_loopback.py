from __future__ import annotations

from rostether.mechanisms.loopback import is_loopback


def test_loopback_is_reported_without_a_resolver() -> None:
    assert all(is_loopback(host) for host in ("localhost", "127.0.0.1", "127.255.0.3", "::1"))
    assert not any(is_loopback(host) for host in ("robot", "127.example.com", "0.0.0.0", "10.0.0.1"))
