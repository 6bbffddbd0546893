from __future__ import annotations

import pytest

from rostether.errors import RemoteProtocolError
from rostether.platform.command_frame import decode_forward, encode_forward
from rostether.platform.command_link import CommandSender, SenderSettings

KEY = b"0123456789abcdef"
SENDER = CommandSender(SenderSettings(3, to_groups=False, key=KEY), 1_000)


@pytest.mark.parametrize("address", ["10.77.0.3", "fd00::3"])
def test_a_query_is_forwarded_whole(address: str) -> None:
    query = SENDER.query()
    assert decode_forward(encode_forward(address, 11412, query), KEY) == (address, 11412, query)


def test_nothing_but_queries_of_the_fleet_is_forwarded() -> None:
    foreign = CommandSender(SenderSettings(3, key=bytes(16)), 1_000)
    nested = SENDER.forward(encode_forward("10.0.0.1", 9, SENDER.query()))
    for datagram in (SENDER.stop(0.0)[0], SENDER.release(), nested, foreign.query(), b"GET / HTTP/1.1"):
        with pytest.raises(RemoteProtocolError):
            decode_forward(encode_forward("10.0.0.1", 80, datagram), KEY)
    with pytest.raises(RemoteProtocolError, match="17 bytes cannot be an address"):
        decode_forward(bytes(17), KEY)
