"""The host's half of a line: TopicInfo handling, negotiation, parameters, whatever a board may say."""

from __future__ import annotations

import math

from fuzz.harness.link_script import step, steps
from rostether.errors import LocalProtocolError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import ParameterRequested, TimeRequested, TopicAnnounced
from rostether.rosserial.host_link import HostLink, HostLinkConfig
from rostether.rosserial.packets import Log, LogLevel, ParameterRequest, TopicInfo
from rostether.rostime import Time

MD5SUM = "992ce8a1687cec8c8bd883ec73ca41d1"
MAX_REPLY_BYTES = 1 << 16
_LIMITS = HostLinkConfig(max_endpoints=16)


def seeds() -> list[bytes]:
    """Return whole negotiations."""
    info = TopicInfo(125, "chatter", "std_msgs/String", MD5SUM, 512)
    time = step(ids.TIME, bytes(8))
    topics = step(ids.PUBLISHER, info.encode()) + step(ids.SUBSCRIBER, info.encode(), kind=3)
    services = step(ids.SERVICE_SERVER_REQUEST, info.encode()) + step(
        ids.SERVICE_SERVER_RESPONSE, info.encode()
    )
    asks = step(ids.PARAMETER, ParameterRequest("~gains").encode())
    logs = step(ids.LOG, Log(LogLevel.WARN, "a line").encode())
    return [
        time + topics + step(125, b"\1\0\0\0a"),
        time + services + asks + logs,
        step(0, b"boot\r\n", kind=6),
    ]


def run(data: bytes) -> None:
    """Play a script to a link that answers all it is asked."""
    link, now_s = HostLink(_LIMITS), 0.0
    link.start(now_s)
    announced = 0
    for received, pause_s in steps(data):
        now_s += pause_s
        for event in [*link.handle_timer(now_s), *link.receive_data(received, now_s)]:
            if isinstance(event, TimeRequested):
                link.answer_time(Time(1, 0), now_s)
            elif isinstance(event, ParameterRequested):
                _answer_parameter(link)
            elif isinstance(event, TopicAnnounced):
                announced += 1
                assert event.info.fault() is None
                try:
                    link.encode_message(event.info.topic_id, b"abc")
                except LocalProtocolError as error:
                    assert "\n" not in str(error)
        assert len(link.data_to_send()) <= MAX_REPLY_BYTES
        due_s = link.get_timer()
        assert due_s is None or math.isfinite(due_s)
    link.stop()


def _answer_parameter(link: HostLink) -> None:
    """Answer as the bridge does: with nothing if the value does not fit, not at all if nothing fits."""
    for ints in ((1,), ()):
        try:
            link.answer_parameter(ints)
        except LocalProtocolError as error:
            assert "\n" not in str(error)
        else:
            return
