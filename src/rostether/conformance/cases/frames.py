"""Finding frames in the received bytes, and dropping invalid bytes.

A case that expects no answer sends a valid message after the invalid bytes: only this message may come back.
Such a case needs no time limit, so a slow machine cannot change the verdict.
"""

from __future__ import annotations

import asyncio

from rostether.conformance.case import CaseList
from rostether.conformance.checked_client import CheckedClient
from rostether.conformance.program import Part
from rostether.conformance.received_frame import Deviation, text_payload
from rostether.rosserial.frame import MAX_PAYLOAD_BYTES, encode_frame

# Ids that the protocol does not use.
UNUSED_IDS = (8, 9, 12, 50, 99)
# Fits in the 64 bytes that a board's serial port buffers while its program is busy.
JOINED_FRAMES = 5
# Longer than pauses in networks, and longer than the time after which a client must drop an incomplete frame.
TORN_S = 1.2
# TCP loses no byte: a client may wait for late packets.
RELIABLE_TORN_S = 6.0

case = CaseList()


@case("frame-split", Part.TEXT)
async def check_split(client: CheckedClient) -> None:
    """A frame is received if its bytes arrive one by one."""
    await client.send_slowly(_frame(client, "split"))
    await client.expect_text("split")


@case("frame-joined", Part.PING)
async def check_joined(client: CheckedClient) -> None:
    """5 frames that arrive together are all received."""
    client.send_bytes(encode_frame(client.id_of("ping"), b"") * JOINED_FRAMES)
    for _ in range(JOINED_FRAMES):
        await client.next_on("pong")


@case("frame-empty", Part.PING)
async def check_empty(client: CheckedClient) -> None:
    """A frame with a payload of 0 bytes is received."""
    client.send(client.id_of("ping"))
    await client.next_on("pong")


@case("frame-noise", Part.TEXT)
async def check_noise(client: CheckedClient) -> None:
    """A frame is received directly after other bytes."""
    await _expect_after(client, b"ets Jan  8 2013,rst cause:2\r\n\x00\x80\xfe")


@case("frame-sync-run", Part.TEXT)
async def check_sync_run(client: CheckedClient) -> None:
    """A frame is received after any number of bytes 0xff."""
    for count in (1, 2, 3):
        await _expect_after(client, b"\xff" * count)


@case("frame-version", Part.TEXT)
async def check_version(client: CheckedClient) -> None:
    """A frame with another version byte is dropped, and the next one is received."""
    frame = bytearray(_frame(client, "wrong"))
    frame[1] = 0xFD
    await _expect_after(client, bytes(frame))


@case("frame-length-check", Part.TEXT)
async def check_length_checksum(client: CheckedClient) -> None:
    """A frame with a wrong length checksum is dropped, and the next one is received."""
    frame = bytearray(_frame(client, "wrong"))
    frame[4] ^= 0x01
    await _expect_after(client, bytes(frame))


@case("frame-check", Part.TEXT)
async def check_checksum(client: CheckedClient) -> None:
    """A frame with a wrong checksum is dropped, and the next one is received."""
    for bit in range(8):
        frame = bytearray(_frame(client, "wrong"))
        frame[-2] ^= 1 << bit
        await _expect_after(client, bytes(frame))


@case("frame-false-header", Part.TEXT)
async def check_false_header(client: CheckedClient) -> None:
    """A frame inside the length that a false header claims is received."""
    # The header is valid, and its length includes the start of the next frame.
    await _expect_after(client, b"\xff\xfe\x03\x00\xfc")


@case("frame-torn", Part.TEXT)
async def check_torn(client: CheckedClient) -> None:
    """After the beginning of a frame and a pause of 1.2 s (6 s over TCP), the next frame is received."""
    # The beginning of the longest frame: the next frame is too short to complete it.
    size = min(client.buffer_of("text_in"), 1024) - 4
    client.send_bytes(_frame(client, "x" * size)[:9])
    await asyncio.sleep(RELIABLE_TORN_S if client.is_over_tcp else TORN_S)
    await _expect_after(client, b"")


@case("frame-longest", Part.TEXT)
async def check_longest(client: CheckedClient) -> None:
    """A message with the announced buffer size is received."""
    # The answer must fit in the client's output buffer, and suit a slow line.
    size = min(client.buffer_of("text_in"), 1024) - 4
    text = "".join(chr(ord("a") + index % 26) for index in range(size))
    client.send_bytes(_frame(client, text))
    await client.expect_text(text)


@case("frame-too-long", Part.TEXT)
async def check_too_long(client: CheckedClient) -> None:
    """A message longer than the buffer is dropped, and the next one is received."""
    size = client.buffer_of("text_in") + 1
    if size > MAX_PAYLOAD_BYTES:
        return
    await _expect_after(client, _frame(client, "x" * (size - 4)))


@case("id-unknown", Part.TEXT)
async def check_unknown_id(client: CheckedClient) -> None:
    """A frame with an id that was not announced is ignored."""
    largest = max(each.info.topic_id for each in client.announcements if each.info is not None)
    wrong = text_payload("wrong")
    await _expect_after(client, encode_frame(largest + 1, wrong) + encode_frame(0x7FFE, wrong))


@case("id-reserved", Part.TEXT)
async def check_reserved_ids(client: CheckedClient) -> None:
    """Frames with reserved ids that the protocol does not use are ignored."""
    await _expect_after(client, b"".join(encode_frame(each, b"\x01") for each in UNUSED_IDS))


@case("id-publisher", Part.TEXT)
async def check_publisher_id(client: CheckedClient) -> None:
    """A frame with the id of one of the client's publishers is ignored."""
    await _expect_after(client, encode_frame(client.id_of("text_out"), text_payload("wrong")))


@case("message-short", Part.TEXT)
async def check_short_message(client: CheckedClient) -> None:
    """A message that is shorter than its type's layout is dropped."""
    payload = text_payload("wrong")[:-2]
    await _expect_after(client, encode_frame(client.id_of("text_in"), payload))


@case("message-long", Part.TEXT)
async def check_long_message(client: CheckedClient) -> None:
    """A message that is longer than its type's layout is dropped."""
    payload = text_payload("wrong") + b"\x00"
    await _expect_after(client, encode_frame(client.id_of("text_in"), payload))


@case("message-count", Part.TEXT)
async def check_false_count(client: CheckedClient) -> None:
    """A message with a string or array length beyond the payload is dropped."""
    payload = b"\xf0\xff\xff\xff" + b"wrong"
    await _expect_after(client, encode_frame(client.id_of("text_in"), payload))


@case("message-text", Part.TEXT)
async def check_texts(client: CheckedClient) -> None:
    """Texts come back unchanged: empty, UTF-8, and with the bytes 0xff and 0xfe."""
    for text in ("", "Grüße, 你好", b"\xff\xfe\xff\xfe"):
        payload = text_payload(text)
        client.send(client.id_of("text_in"), payload)
        answer = await client.next_on("text_out")
        if answer != payload:
            raise Deviation(f"{payload.hex(' ')} came back as {answer.hex(' ')}")


def _frame(client: CheckedClient, text: str) -> bytes:
    return encode_frame(client.id_of("text_in"), text_payload(text))


async def _expect_after(client: CheckedClient, data: bytes) -> None:
    """Send bytes and a valid message together: only this message may come back."""
    client.send_bytes(data + _frame(client, "valid"))
    await client.expect_text("valid")
