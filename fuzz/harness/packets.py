"""The packets of the protocol: what is decoded can be encoded, and is then decoded alike."""

from __future__ import annotations

from rostether.errors import RostetherError
from rostether.rosserial.packets import (
    Log,
    LogLevel,
    ParameterRequest,
    ParameterResponse,
    TopicInfo,
    decode_time,
    encode_time,
)
from rostether.rostime import Time

MD5SUM = "992ce8a1687cec8c8bd883ec73ca41d1"
_DECODERS = (TopicInfo.decode, Log.decode, ParameterRequest.decode, ParameterResponse.decode)


def seeds() -> list[bytes]:
    """Return one packet of each kind."""
    return [
        TopicInfo(125, "chatter", "std_msgs/String", MD5SUM, 512).encode(),
        Log(LogLevel.WARN, "a line").encode(),
        ParameterRequest("~gains").encode(),
        ParameterResponse((1, -2), (0.5,), ("a", "")).encode(),
        encode_time(Time(1, 2)),
    ]


def run(data: bytes) -> None:
    """Decode as each kind of packet."""
    for decode in _DECODERS:
        packet = decode(data)
        if packet is not None:
            try:
                again = decode(packet.encode())
            except RostetherError:
                continue
            # Floats that are no number equal nothing.
            assert repr(again) == repr(packet)
    info = TopicInfo.read(data)
    if info is not None:
        assert info.fault() is None or "\n" not in str(info.fault())
    decode_time(data)
