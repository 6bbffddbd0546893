from __future__ import annotations

import asyncio
import random

import pytest

from rostether.errors import TransportClosedError
from rostether.transports.memory import Direction, memory_pair
from rostether.transports.transport import HIGH_WATER_BYTES
from unit.transports.recorder import Recorder


async def test_carry_bytes_both_ways_in_order() -> None:
    first, second = memory_pair()
    near, far = Recorder(), Recorder()
    first.start(near)
    second.start(far)
    for part in (b"a", bytearray(b"bc"), memoryview(b"def")):
        first.write(part)
    second.write(b"back")
    await far.until_received(b"abcdef")
    await near.until_received(b"back")


async def test_deliver_nothing_inside_write() -> None:
    first, second = memory_pair()
    far = Recorder()
    second.start(far)
    first.write(b"x")
    assert not far.data
    await far.until_received(b"x")


async def test_keep_what_came_before_start() -> None:
    first, second = memory_pair()
    first.write(b"early")
    await asyncio.sleep(0)
    far = Recorder()
    second.start(far)
    await far.until_received(b"early")


async def test_pausing_a_reader_pauses_its_writer() -> None:
    first, second = memory_pair()
    near, far = Recorder(), Recorder()
    first.start(near)
    second.start(far)
    second.pause_reading()
    chunk = b"z" * 1024
    while not near.write_pauses:
        first.write(chunk)
    assert first.write_buffer_bytes > HIGH_WATER_BYTES
    await asyncio.sleep(0)
    assert not far.data
    sent = first.write_buffer_bytes
    second.resume_reading()
    await far.until(lambda seen: len(seen.data) == sent)
    assert near.write_pauses == [True, False]
    assert first.write_buffer_bytes == 0


async def test_a_wire_that_cannot_pause_loses_what_its_paused_reader_misses() -> None:
    first, second = memory_pair(can_pause=False)
    near, far = Recorder(), Recorder()
    first.start(near)
    second.start(far)
    assert not second.can_pause
    second.pause_reading()
    for _ in range(200):
        first.write(b"z" * 1024)
    second.resume_reading()
    await far.until(lambda seen: len(seen.data) == HIGH_WATER_BYTES)
    first.write(b"end")
    await far.until(lambda seen: seen.data.endswith(b"end"))
    assert len(far.data) == HIGH_WATER_BYTES + 3
    assert near.write_pauses == []


async def test_the_manipulator_sees_each_chunk_and_its_direction() -> None:
    seen: list[tuple[bytes, Direction]] = []

    def lose_digits(chunk: bytes, direction: Direction) -> bytes:
        seen.append((chunk, direction))
        return bytes(byte for byte in chunk if byte not in b"0123456789")

    first, second = memory_pair(lose_digits)
    near, far = Recorder(), Recorder()
    first.start(near)
    second.start(far)
    first.write(b"a1b2")
    first.write(b"99")
    second.write(b"3c")
    await far.until_received(b"ab")
    await near.until_received(b"c")
    assert seen == [
        (b"a1b2", Direction.FIRST_TO_SECOND),
        (b"99", Direction.FIRST_TO_SECOND),
        (b"3c", Direction.SECOND_TO_FIRST),
    ]


async def test_close_delivers_written_bytes_and_notifies_both_ends_once() -> None:
    first, second = memory_pair()
    near, far = Recorder(), Recorder()
    first.start(near)
    second.start(far)
    first.write(b"last words")
    first.close()
    first.close()
    first.write(b"too late")
    await far.until_lost()
    await near.until_lost()
    assert bytes(far.data) == b"last words"
    assert isinstance(far.losses[0], TransportClosedError)
    assert near.losses == [None]
    await first.wait_closed()
    await second.wait_closed()
    second.close()
    await asyncio.sleep(0)
    assert len(far.losses) == len(near.losses) == 1


async def test_a_receiver_that_starts_after_the_end_gets_connection_lost() -> None:
    first, second = memory_pair()
    first.write(b"bye")
    first.close()
    far = Recorder()
    second.start(far)
    await far.until_lost()
    assert bytes(far.data) == b"bye"


async def test_no_data_is_delivered_after_close() -> None:
    first, second = memory_pair()
    near, far = Recorder(), Recorder()
    first.start(near)
    second.start(far)
    second.write(b"x")
    first.close()
    await near.until_lost()
    assert not near.data


@pytest.mark.parametrize("seed", range(5))
async def test_random_traffic_with_pauses_loses_nothing(seed: int) -> None:
    rng = random.Random(seed)
    first, second = memory_pair()
    near, far = Recorder(), Recorder()
    first.start(near)
    second.start(far)
    sent = bytearray()
    for _ in range(300):
        match rng.randrange(4):
            case 0:
                second.pause_reading()
            case 1:
                second.resume_reading()
            case 2:
                await asyncio.sleep(0)
            case _:
                data = rng.randbytes(rng.randrange(4000))
                sent += data
                first.write(data)
    second.resume_reading()
    await far.until_received(bytes(sent))
    assert first.write_buffer_bytes == 0
    assert near.write_pauses[-1:] != [True]
