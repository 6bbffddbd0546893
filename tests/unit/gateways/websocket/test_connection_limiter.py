from __future__ import annotations

import asyncio

from rostether.gateways.websocket import connection_limiter as door
from rostether.gateways.websocket.connection_limiter import ConnectionLimiter


class Accepted(asyncio.BaseTransport):
    """A connection with only its two addresses."""

    def __init__(self, peer: str = "127.0.0.1", own: str = "127.0.0.1") -> None:
        super().__init__({"peername": (peer, 5000), "sockname": (own, 9090)})


async def test_networks_that_were_named_may_connect_and_this_machine() -> None:
    reported: list[str] = []
    limiter = ConnectionLimiter(("192.168.1.0/24",), 10, reported.append)
    assert limiter.admit(Accepted("192.168.1.7", "192.168.1.2"))
    assert limiter.admit(Accepted())
    assert not limiter.admit(Accepted("10.0.0.1", "192.168.1.2"))
    assert reported == ["refused 10.0.0.1:5000: 10.0.0.1 is not in the networks of --allow; add it there"]
    assert limiter.open_count == 2


async def test_a_place_that_was_left_is_free() -> None:
    reported: list[str] = []
    limiter = ConnectionLimiter((), 1, reported.append)
    assert limiter.admit(Accepted())
    assert not limiter.admit(Accepted("::1", "::1"))
    assert reported == ["refused [::1]:5000: the limit of open connections (1) is reached; close another one"]
    limiter.release()
    assert limiter.admit(Accepted())


async def test_a_connection_that_has_gone_already_takes_no_place() -> None:
    reported: list[str] = []
    limiter = ConnectionLimiter((), 1, reported.append)
    assert not limiter.admit(asyncio.BaseTransport({}))
    assert (limiter.open_count, reported) == (0, ["refused a client: it has disconnected"])


async def test_each_reason_is_reported_once_in_a_while_and_few_of_them() -> None:
    reported: list[str] = []
    limiter = ConnectionLimiter((), 1, reported.append)
    for _ in range(2):
        for number in range(door.MAX_REASONS + 1):
            limiter.report_refusal(Accepted(), f"page\n{number}")
    assert reported == [f"refused 127.0.0.1:5000: page {number}" for number in range(door.MAX_REASONS)]
    limiter._reported_until_s = 0.0
    limiter.report_refusal(Accepted(), "page 0")
    assert reported[-1].endswith("page 0 (7 more since the last such line)")
