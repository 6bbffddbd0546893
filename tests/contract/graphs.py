"""What the contract tests of all graphs share: types, a collector of what arrives, and waiting."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from rostether.msgdef.interface import MessageType, ServiceType

STRING = MessageType("std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data\n")
BOOL = MessageType("std_msgs/Bool", "8b94c1b53db61fb6aed406028ad6332a", "bool data\n")
SET_BOOL = ServiceType(
    "std_srvs/SetBool",
    "09fb03525b03e7ea1fd3992bafd87e16",
    MessageType("std_srvs/SetBoolRequest", "8b94c1b53db61fb6aed406028ad6332a", "bool data\n"),
    MessageType(
        "std_srvs/SetBoolResponse", "937c9679a518e3a18d831e57125ea522", "bool success\nstring message\n"
    ),
)
EMPTY = ServiceType(
    "std_srvs/Empty",
    "d41d8cd98f00b204e9800998ecf8427e",
    MessageType("std_srvs/EmptyRequest", "d41d8cd98f00b204e9800998ecf8427e"),
    MessageType("std_srvs/EmptyResponse", "d41d8cd98f00b204e9800998ecf8427e"),
)


def string(text: str) -> bytes:
    """Return a serialized std_msgs/String."""
    encoded = text.encode()
    return len(encoded).to_bytes(4, "little") + encoded


@dataclass
class Inbox:
    """Collects what a subscriber hands on."""

    payloads: list[bytes] = field(default_factory=list)
    headers: list[dict[str, str]] = field(default_factory=list)

    def take(self, payloads: Sequence[bytes]) -> None:
        """Be an `on_messages`."""
        self.payloads.extend(payloads)

    def take_header(self, fields: Mapping[str, str]) -> None:
        """Be an `on_connection`."""
        self.headers.append(dict(fields))


async def until(condition: Callable[[], object], timeout_s: float = 10.0) -> None:
    """Wait until a condition holds; fails when it does not in time."""
    deadline_s = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > deadline_s:
            raise AssertionError("the condition never became true")
        await asyncio.sleep(0.001)
