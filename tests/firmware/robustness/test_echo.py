"""Real firmware on a simulated Uno at 57600 baud sends messages back through the real bridge, unchanged."""

from __future__ import annotations

import random
import struct
from pathlib import Path

import pytest

from firmware.examples.stage import running
from rostether.serde.values import Message

SKETCH = str(Path(__file__).parent / "sketches" / "Echo")
# The most that fits into an Uno's buffer of 280 bytes.
LONGEST_TEXT = 276


def array_payload(form: str, values: list[int] | list[float]) -> bytes:
    return struct.pack(f"<III{len(values)}{form}", 0, 0, len(values), *values)


@pytest.mark.timeout(300)
async def test_messages_of_280_bytes_are_sent_back_unchanged() -> None:
    async with running(SKETCH) as stage:
        inbox = await stage.listen("/texts_out", "std_msgs/String")
        publisher = await stage.publisher("/texts_in", "std_msgs/String")
        for number in range(20):
            expected = f"{number:03}".ljust(LONGEST_TEXT - (number % 3), "abcdefg"[number % 7])
            publisher.publish(data=expected)
            await inbox.wait_for_count(number + 1)
            assert inbox.messages[-1].data == expected


@pytest.mark.timeout(300)
async def test_integers_of_64_bits_are_sent_back_exactly() -> None:
    numbers = random.Random(1)
    edges = [0, -1, 1, 2**63 - 1, -(2**63), 2**32, -(2**32) - 1]
    batches = [edges, *([numbers.randrange(-(2**63), 2**63) for _ in range(30)] for _ in range(3))]
    async with running(SKETCH) as stage:
        inbox = await stage.listen("/integers_out", "std_msgs/Int64MultiArray")
        publisher = await stage.publisher("/integers_in", "std_msgs/Int64MultiArray")
        for count, batch in enumerate(batches, 1):
            publisher.raw.publish_raw([array_payload("q", batch)])
            await inbox.wait_for_count(count)
            assert list(inbox.messages[-1].data) == batch


@pytest.mark.timeout(300)
async def test_doubles_are_sent_back_as_the_nearest_floats() -> None:
    numbers = random.Random(2)

    def random_double() -> float:
        return float(struct.unpack("<d", struct.pack("<Q", numbers.getrandbits(64)))[0])

    edges = [
        0.0,
        -0.0,
        1.0,
        -1.5,
        0.1,
        1e-45,
        7e-46,
        1e-38,
        3.4028234663852886e38,
        3.4028235677973366e38,
        1e300,
    ]
    edges += [float("inf"), -float("inf"), 16777217.0, 5e-324, 1 + 2**-24, 1 + 3 * 2**-24]
    near = [numbers.uniform(-1, 1) * 10.0 ** numbers.randrange(-45, 39) for _ in range(30)]
    batches = [edges, [-each for each in edges], near, [random_double() for _ in range(30)]]
    async with running(SKETCH) as stage:
        inbox = await stage.listen("/reals_out", "std_msgs/Float64MultiArray")
        publisher = await stage.publisher("/reals_in", "std_msgs/Float64MultiArray")
        for count, batch in enumerate(batches, 1):
            publisher.raw.publish_raw([array_payload("d", batch)])
            await inbox.wait_for_count(count)
            assert _bits(inbox.messages[-1]) == [_nearest(each) for each in batch]


def _bits(message: Message) -> list[bytes]:
    return [struct.pack("<d", each) for each in message.data]


def _nearest(value: float) -> bytes:
    """Return the bits of the nearest float, as a double."""
    try:
        single = struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        single = float("inf") if value > 0 else -float("inf")
    return struct.pack("<d", single)
