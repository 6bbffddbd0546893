"""The life cycle of a session: time, silence, stop, probes, and reconnection."""

from __future__ import annotations

import asyncio

from rostether.conformance.case import CaseList
from rostether.conformance.checked_client import CheckedClient
from rostether.conformance.program import Part
from rostether.conformance.received_frame import Deviation, is_time_request, read_text, text_payload
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.packets import decode_time

# A client requests the time every 2.2 to 2.5 s; after 5 s, a host regards it as disconnected.
LONGEST_PERIOD_S = 5.0
# The client's clock may be late by the round trip time of a slow line and a busy machine.
CLOCK_TOLERANCE_S = 1.0
# A time answer in between may correct the clock by half the round trip time.
ADVANCE_S, ADVANCE_TOLERANCE_S = 0.5, 0.25
# Shorter than the period of time requests, so two answers within this time are not a coincidence.
PROBE_ANSWER_S = 1.5
PROBE = b"\xff\x00"
PROBE_PAUSE_S = 0.1
# After 11 s without an answer, a client regards the host as disconnected; this adds a margin for clock errors
# and slow programs.
LOST_S = 14.0

case = CaseList()


@case("time-period")
async def check_period(client: CheckedClient) -> None:
    """A configured client asks for the time at least every 5 s."""
    # The first one may be the answer to an earlier case.
    for _ in range(2):
        await client.expect(is_time_request, "a time request", LONGEST_PERIOD_S)


@case("time-clock", Part.PING)
async def check_clock(client: CheckedClient) -> None:
    """The client's clock follows the host's answers."""
    await _expect_clock(client)


@case("time-advance", Part.PING)
async def check_advance(client: CheckedClient) -> None:
    """The client's clock advances between the host's answers, even within a second."""
    earlier_s, earlier = await _read_clock(client)
    await asyncio.sleep(ADVANCE_S)
    later_s, later = await _read_clock(client)
    # The host's time before and after each reading bounds the time that passed.
    min_s, max_s = later_s[0] - earlier_s[1], later_s[1] - earlier_s[0]
    if not min_s - ADVANCE_TOLERANCE_S <= later - earlier <= max_s + ADVANCE_TOLERANCE_S:
        raise Deviation(f"the client's clock advanced by {later - earlier:.3f} s in {min_s:.3f} s")


@case("time-layout", Part.PING)
async def check_time_layout(client: CheckedClient) -> None:
    """A time answer that is not 8 bytes long is ignored."""
    client.send(ids.TIME, b"\x01\x02\x03\x04\x05\x06\x07")
    await _expect_clock(client)


@case("time-lost", Part.TEXT, wait_s=LOST_S)
async def check_lost(client: CheckedClient) -> None:
    """After 11 s without time answers, the client sends no messages."""
    client.require_configuration()
    client.answers_time = False
    await asyncio.sleep(LOST_S)
    await _expect_dropped(client)


@case("stop-silent", Part.TEXT)
async def check_stop(client: CheckedClient) -> None:
    """After the host's stop (id 11) the client sends no messages."""
    _stop(client)
    await _expect_dropped(client)


@case("stop-resume", Part.TEXT)
async def check_resume(client: CheckedClient) -> None:
    """After a stop and a new topic request, the client sends messages again."""
    _stop(client)
    await client.configure()
    client.send(client.id_of("text_in"), text_payload("again"))
    await client.next_on("text_out")


@case("probe-waiting")
async def check_probe(client: CheckedClient) -> None:
    """A client that waits for a request answers a wrong version byte with a time request."""
    _stop(client)
    for _ in range(2):
        # One answer is enough for a burst of probes.
        await asyncio.sleep(PROBE_PAUSE_S)
        client.skip()
        client.send_bytes(PROBE)
        await client.expect(is_time_request, "an answer to ff 00", PROBE_ANSWER_S)


@case("probe-configured", Part.TEXT)
async def check_probe_configured(client: CheckedClient) -> None:
    """A wrong version byte does not disturb a configured client."""
    client.send_bytes(PROBE + encode_frame(client.id_of("text_in"), text_payload("valid")))
    await client.next_on("text_out")


@case("line-again")
async def check_line_again(client: CheckedClient) -> None:
    """The client announces its topics on a line that is closed and opened again."""
    await client.reconnect()
    found = await client.configure()
    if len(found) < len(client.announcements):
        raise Deviation(f"it announces {len(found)} endpoints instead of {len(client.announcements)}")


def _stop(client: CheckedClient) -> None:
    # A disconnected host does not answer.
    client.answers_time = False
    client.require_configuration()
    client.send(ids.TX_STOP)


async def _expect_dropped(client: CheckedClient) -> None:
    """Send a string to a client that must not answer."""
    client.skip()
    client.send(client.id_of("text_in"), text_payload("unwanted"))
    # A client that answers the probe has handled the string. Its topics are not requested before, because a
    # client that is configured again may answer the string.
    client.send_bytes(PROBE)
    text_out = client.id_of("text_out")
    first = await client.find(lambda each: is_time_request(each) or each.topic_id == text_out, PROBE_ANSWER_S)
    if first is not None and first.topic_id == text_out:
        raise Deviation(f"{read_text(first.payload)!r} came back")


async def _read_clock(client: CheckedClient) -> tuple[tuple[float, float], float]:
    """Return the host's times before and after a reading of the client's clock, and the reading."""
    before_s = client.host_time_s()
    client.send(client.id_of("ping"))
    payload = await client.next_on("pong")
    time = decode_time(payload)
    if time is None:
        raise Deviation(f"{payload.hex(' ')} is not a std_msgs/Time")
    return (before_s, client.host_time_s()), time.to_s()


async def _expect_clock(client: CheckedClient) -> None:
    (before_s, after_s), device_s = await _read_clock(client)
    if not before_s - CLOCK_TOLERANCE_S <= device_s <= after_s + CLOCK_TOLERANCE_S:
        raise Deviation(f"the client's clock differs from the host's by {device_s - after_s:+.3f} s")
