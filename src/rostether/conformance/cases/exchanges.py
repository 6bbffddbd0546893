"""Numbers, services, parameters and logs."""

from __future__ import annotations

import struct

from rostether.conformance.case import CaseList
from rostether.conformance.checked_client import CheckedClient
from rostether.conformance.program import (
    FLOAT_PARAMETER,
    INT_PARAMETER,
    NONE_TEXT,
    TEXT_PARAMETER,
    Command,
    Part,
)
from rostether.conformance.received_frame import Deviation, text_payload
from rostether.mechanisms.text import counted
from rostether.rosserial import topic_id as ids
from rostether.rosserial.packets import Log, LogLevel, ParameterResponse

_DOUBLE = struct.Struct("<d")
# These values are also exact as floats, because a double has 4 bytes on some processors.
REALS = (0.0, -1.5, 2.0**100, 1.0 / 1024)

case = CaseList()


@case("message-real", Part.REAL)
async def check_reals(client: CheckedClient) -> None:
    """A std_msgs/Float64 comes back in 8 bytes, with values that a float holds exactly."""
    for value in REALS:
        payload = _DOUBLE.pack(value)
        client.send(client.id_of("real_in"), payload)
        answer = await client.next_on("real_out")
        if answer != payload:
            raise Deviation(f"{value!r} came back as {answer.hex(' ')}")


@case("service-answer", Part.SWITCH)
async def check_answer(client: CheckedClient) -> None:
    """A request is answered on the response id of the service."""
    await _expect_switched(client, is_on=True)


@case("service-order", Part.SWITCH)
async def check_order(client: CheckedClient) -> None:
    """Two consecutive requests are each answered with their own response."""
    await _expect_switched(client, is_on=True)
    await _expect_switched(client, is_on=False)


@case("service-call", Part.TRIGGER, Part.COMMAND, Part.TEXT)
async def check_call(client: CheckedClient) -> None:
    """A call is sent on the request id of the service, and ends with its response."""
    await _begin_call(client)
    _respond(client, "done")
    await client.expect_text("done")


@case("service-call-time", Part.TRIGGER, Part.COMMAND, Part.TEXT)
async def check_call_time(client: CheckedClient) -> None:
    """A time answer during a call does not end the call."""
    await _begin_call(client)
    client.send_bytes(client.time_answer())
    _respond(client, "after the time")
    await client.expect_text("after the time")


@case("service-late", Part.TRIGGER, Part.COMMAND, Part.TEXT)
async def check_late_response(client: CheckedClient) -> None:
    """A response without a call is ignored, and is not the answer to the next call."""
    _respond(client, "late")
    await _begin_call(client)
    _respond(client, "in time")
    await client.expect_text("in time")


@case("parameter-ints", Part.COMMAND, Part.REAL)
async def check_ints(client: CheckedClient) -> None:
    """A parameter of integers is read from the first list of the answer."""
    client.set_parameter(INT_PARAMETER, ParameterResponse(ints=(7, -32000)))
    _command(client, Command.GET_INTS)
    await _expect_reals(client, 7.0, -32000.0)


@case("parameter-float", Part.COMMAND, Part.REAL)
async def check_float(client: CheckedClient) -> None:
    """A parameter of floats is read from the second list of the answer."""
    client.set_parameter(FLOAT_PARAMETER, ParameterResponse(floats=(0.25,)))
    _command(client, Command.GET_FLOAT)
    await _expect_reals(client, 0.25)


@case("parameter-text", Part.COMMAND, Part.TEXT)
async def check_text(client: CheckedClient) -> None:
    """A parameter of text is read from the third list of the answer."""
    client.set_parameter(TEXT_PARAMETER, ParameterResponse(strings=("left arm",)))
    _command(client, Command.GET_TEXT)
    await client.expect_text("left arm")


@case("parameter-missing", Part.COMMAND, Part.TEXT)
async def check_missing(client: CheckedClient) -> None:
    """An answer with three empty lists means that the parameter does not exist."""
    client.set_parameter(TEXT_PARAMETER, ParameterResponse())
    _command(client, Command.GET_TEXT)
    await client.expect_text(NONE_TEXT)


@case("log-levels", Part.COMMAND)
async def check_logs(client: CheckedClient) -> None:
    """Logs have the levels 0 (debug) to 4 (fatal), and their text."""
    _command(client, Command.LOG)
    for level in LogLevel:
        wanted = Log(level, level.name.lower()).encode()
        frame = await client.expect(lambda each: each.topic_id == ids.LOG, f"the log at level {level:d}")
        if frame.payload != wanted:
            raise Deviation(f"the log is {frame.payload[:40].hex(' ')}, not {wanted.hex(' ')}")


def _command(client: CheckedClient, command: Command) -> None:
    client.send(client.id_of("command"), bytes((command,)))


async def _begin_call(client: CheckedClient) -> None:
    request_id = client.id_of("trigger", ids.SERVICE_CLIENT_REQUEST)
    _command(client, Command.CALL)
    frame = await client.expect(lambda each: each.topic_id == request_id, "the request of a call")
    if frame.payload:
        raise Deviation(f"the empty request has {counted(len(frame.payload), 'byte')}")


def _respond(client: CheckedClient, text: str) -> None:
    client.send(client.id_of("trigger", ids.SERVICE_CLIENT_RESPONSE), b"\x01" + text_payload(text))


async def _expect_switched(client: CheckedClient, *, is_on: bool) -> None:
    client.send(client.id_of("switch", ids.SERVICE_SERVER_REQUEST), bytes((is_on,)))
    response_id = client.id_of("switch", ids.SERVICE_SERVER_RESPONSE)
    frame = await client.expect(lambda each: each.topic_id == response_id, "the response")
    wanted = bytes((is_on,)) + text_payload("on" if is_on else "off")
    if frame.payload != wanted:
        raise Deviation(f"the response is {frame.payload[:40].hex(' ')}, not {wanted.hex(' ')}")


async def _expect_reals(client: CheckedClient, *wanted: float) -> None:
    for each in wanted:
        payload = await client.next_on("real_out")
        if payload != _DOUBLE.pack(each):
            raise Deviation(f"the client reports {payload.hex(' ')}, not {each!r}")
