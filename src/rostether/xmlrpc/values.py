"""The XML-RPC values that ROS masters and nodes exchange, as Python values.

| XML-RPC                   | Python                                       |
| ---                       | ---                                          |
| boolean, int/i4, double   | bool, int (32 bits), float                   |
| string, or a bare value   | str                                          |
| base64                    | bytes                                        |
| dateTime.iso8601          | DateTime, the text as it was sent            |
| array, struct, nil        | list, dict with str keys, None (read only)   |
"""

from __future__ import annotations

import re
from typing import TypeAlias

from rostether.errors import RemoteProtocolError

XmlRpcValue: TypeAlias = (
    bool | int | float | str | bytes | list["XmlRpcValue"] | dict[str, "XmlRpcValue"] | None
)

# The nesting of arrays and structs: deeper than any parameter tree, and far below the recursion limit.
MAX_NESTING = 100
# XML-RPC integers have 32 bits, in rospy and roscpp too.
MIN_INT, MAX_INT = -(2**31), 2**31 - 1

# Characters that XML does not allow.
NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


class DateTime(str):
    """A dateTime.iso8601 value, kept as its text, so that it is sent back unchanged."""

    __slots__ = ()


class FaultError(RemoteProtocolError):
    """The peer answered a call with a fault; `code` is its faultCode, `text` its faultString."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code
        self.text = text
