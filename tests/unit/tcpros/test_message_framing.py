"""Message framing: whole, byte by byte, in every chunking, and the limits."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rostether.errors import RemoteProtocolError
from rostether.tcpros.message_framing import MessageDecoder, encode_messages, measure_oldest

BATCHES: list[list[bytes]] = [
    [],
    [b""],
    [b""] * 20,
    [b"a"],
    [b"abcd"] * 50,
    [b"abc", b"", b"a" * 300, b"b"] * 9,
    [bytes(64)] * 30 + [b"other"] + [bytes(64)] * 30,
    # Payloads that look like prefixes must not be taken for a run.
    [b"\x04\0\0\0"] * 12 + [b"\x08\0\0\0abcd"] * 12,
    [b"x" * 70_000, b"y", b"z" * 70_000],
]


def decode(chunks: list[bytes]) -> list[bytes]:
    decoder = MessageDecoder()
    return [payload for chunk in chunks for payload in decoder.feed(chunk)]


@pytest.mark.parametrize("payloads", BATCHES)
def test_batches_come_back_however_they_are_cut(payloads: list[bytes]) -> None:
    wire = encode_messages(payloads)
    assert len(wire) == sum(4 + len(payload) for payload in payloads)
    assert decode([wire]) == payloads
    for size in (1, 2, 3, 5, 64, 1000) if len(wire) < 10_000 else (1000, 65536):
        assert decode([wire[i : i + size] for i in range(0, len(wire), size)]) == payloads


@given(
    st.lists(st.binary(max_size=12) | st.just(b"same length!"), max_size=40),
    st.lists(st.integers(min_value=0, max_value=500), max_size=8),
)
def test_chunks_of_any_size_give_the_same_payloads(payloads: list[bytes], cuts: list[int]) -> None:
    wire = encode_messages(payloads)
    edges = sorted({0, len(wire), *(cut for cut in cuts if cut < len(wire))})
    assert decode([wire[a:b] for a, b in itertools.pairwise(edges)]) == payloads


def test_an_incomplete_message_is_held_back() -> None:
    decoder = MessageDecoder()
    wire = encode_messages([b"first", b"second"])
    assert decoder.feed(wire[:-1]) == [b"first"]
    assert decoder.feed(b"") == []
    assert decoder.feed(wire[-1:] + b"\x01") == [b"second"]
    assert decoder.feed(b"\0\0\0z") == [b"z"]


@pytest.mark.parametrize("count", [1, 30])
@pytest.mark.parametrize("lead", [[], [b"ok"]])
def test_a_length_above_the_limit_ends_the_stream(count: int, lead: list[bytes]) -> None:
    decoder = MessageDecoder(max_message_bytes=10)
    with pytest.raises(RemoteProtocolError, match="message of 11 bytes, more than 10"):
        decoder.feed(encode_messages(lead + [b"x" * 11] * count))
    assert (
        MessageDecoder(max_message_bytes=10).feed(encode_messages([b"x" * 10] * count)) == [b"x" * 10] * count
    )


def test_a_huge_length_allocates_no_memory() -> None:
    decoder = MessageDecoder(max_message_bytes=0xFFFF_FFFF)
    assert decoder.feed(b"\xff\xff\xff\xff" + b"a bit") == []


def test_the_oldest_messages_are_measured_whole() -> None:
    wire = encode_messages([b"aa", b"bbbb", b"", b"c"])
    assert measure_oldest(wire, 1) == (6, 1)
    assert measure_oldest(wire, 6) == (6, 1)
    assert measure_oldest(wire, 7) == (14, 2)
    # The newest message stays, however large the excess is.
    assert measure_oldest(wire, 1000) == (18, 3)
