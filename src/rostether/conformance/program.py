"""The conformance program for clients under test, here as a Python Device.

    part      client has                                      on a message
    TEXT      subscriber text_in, publisher text_out          sends each std_msgs/String back
    REAL      subscriber real_in, publisher real_out          sends each std_msgs/Float64 back
    PING      subscriber ping (std_msgs/Empty),               sends its clock's time
              publisher pong (std_msgs/Time)
    COMMAND   subscriber command (std_msgs/UInt8)             executes the number's Command
    SWITCH    service server switch (std_srvs/SetBool)        success = data, message "on" or "off"
    TRIGGER   service client trigger (std_srvs/Trigger)       called by Command.CALL

All names begin with `conformance/`. Cases that need a missing part are skipped.
"""

from __future__ import annotations

import asyncio
from enum import Enum, IntEnum
from typing import NamedTuple

from rostether.device.device import Device
from rostether.errors import GraphError, TransportError
from rostether.graph.ports import Level
from rostether.mechanisms.tasks import start_task
from rostether.rosserial import topic_id as ids
from rostether.serde.values import Message

PREFIX = "conformance/"
INT_PARAMETER = f"{PREFIX}ints"
FLOAT_PARAMETER = f"{PREFIX}float"
TEXT_PARAMETER = f"{PREFIX}text"
# The program sends this on text_out if it gets no parameter or no response.
NONE_TEXT = "none"


class Command(IntEnum):
    """The actions for the numbers on `command`."""

    LOG = 1  # logs "debug", "info", "warn", "error" and "fatal", each at its level
    CALL = 2  # calls trigger, and sends the response's message on text_out
    GET_INTS = 3  # gets two integers, and sends both on real_out
    GET_FLOAT = 4  # gets a number, and sends it on real_out
    GET_TEXT = 5  # gets a text, and sends it on text_out


class Role(NamedTuple):
    """One endpoint of the program; `announced_on` are the reserved ids of its announcements."""

    name: str
    type: str
    announced_on: tuple[int, ...]


_IN, _OUT = (ids.SUBSCRIBER,), (ids.PUBLISHER,)
_SERVER = (ids.SERVICE_SERVER_RESPONSE, ids.SERVICE_SERVER_REQUEST)
_CLIENT = (ids.SERVICE_CLIENT_REQUEST, ids.SERVICE_CLIENT_RESPONSE)


class Part(Enum):
    """The parts of the program, each with its endpoints."""

    TEXT = (Role("text_in", "std_msgs/String", _IN), Role("text_out", "std_msgs/String", _OUT))
    REAL = (Role("real_in", "std_msgs/Float64", _IN), Role("real_out", "std_msgs/Float64", _OUT))
    PING = (Role("ping", "std_msgs/Empty", _IN), Role("pong", "std_msgs/Time", _OUT))
    COMMAND = (Role("command", "std_msgs/UInt8", _IN),)
    SWITCH = (Role("switch", "std_srvs/SetBool", _SERVER),)
    TRIGGER = (Role("trigger", "std_srvs/Trigger", _CLIENT),)


class ConformanceProgram:
    """The program on a Device; declare it before the device opens its line."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._tasks: set[asyncio.Task[None]] = set()
        self._text = device.publisher(f"{PREFIX}text_out", "std_msgs/String")
        self._real = device.publisher(f"{PREFIX}real_out", "std_msgs/Float64")
        self._pong = device.publisher(f"{PREFIX}pong", "std_msgs/Time")
        device.subscriber(f"{PREFIX}text_in", "std_msgs/String", self._text.publish)
        device.subscriber(f"{PREFIX}real_in", "std_msgs/Float64", self._real.publish)
        device.subscriber(f"{PREFIX}ping", "std_msgs/Empty", lambda _: self._pong.publish(data=device.now()))
        device.subscriber(f"{PREFIX}command", "std_msgs/UInt8", self._run_command)
        device.service_server(
            f"{PREFIX}switch",
            "std_srvs/SetBool",
            lambda request: {"success": request.data, "message": "on" if request.data else "off"},
        )
        self._trigger = device.service_client(f"{PREFIX}trigger", "std_srvs/Trigger")

    def _run_command(self, message: Message) -> None:
        match message.data:
            case Command.LOG:
                for level in Level:
                    self._device.log(level, level.name.lower())
            case Command.CALL:
                start_task(self._tasks, self._call())
            case Command.GET_INTS:
                start_task(self._tasks, self._send_numbers(INT_PARAMETER))
            case Command.GET_FLOAT:
                start_task(self._tasks, self._send_numbers(FLOAT_PARAMETER))
            case Command.GET_TEXT:
                start_task(self._tasks, self._send_text())

    async def _call(self) -> None:
        try:
            response = await self._trigger.call()
        except GraphError:
            self._text.publish(data=NONE_TEXT)
        else:
            self._text.publish(data=response.message)

    async def _send_numbers(self, name: str) -> None:
        try:
            value = await self._device.get_param(name)
        except (GraphError, TransportError):
            self._text.publish(data=NONE_TEXT)
            return
        for number in value if isinstance(value, list) else [value]:
            self._real.publish(data=number)

    async def _send_text(self) -> None:
        try:
            value = await self._device.get_param(TEXT_PARAMETER)
        except (GraphError, TransportError):
            value = NONE_TEXT
        self._text.publish(data=value)
