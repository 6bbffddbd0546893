"""The link of a host: TopicInfo, negotiation and parameters, with any data from a board.

Limits are low. A separate list of the announcements determines what the link must refuse.
"""

from __future__ import annotations

import math
import random

from fuzz.grammar import near
from fuzz.harness.link_script import MAX_BODY_BYTES, burst, random_step, step, steps
from fuzz.lowering import lowered
from rostether.errors import LocalProtocolError
from rostether.rosserial import control_rate, host_output
from rostether.rosserial import topic_id as ids
from rostether.rosserial.control_rate import Allowance
from rostether.rosserial.events import (
    DeviceReset,
    HostEvent,
    LogReceived,
    MessagesReceived,
    ParameterRequested,
    ServiceAnnounced,
    ServiceRole,
    ServiceWithdrawn,
    TimeRequested,
    TopicAnnounced,
    TopicRole,
    TopicWithdrawn,
)
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.host_link import HostLink, HostLinkConfig
from rostether.rosserial.packets import Log, LogLevel, ParameterRequest, TopicInfo
from rostether.rostime import Time

MD5SUM = "992ce8a1687cec8c8bd883ec73ca41d1"
MAX_ENDPOINTS = 4
MAX_REPLY_BYTES = 256
# Larger buffers are not tried: that takes long, and finds nothing more.
MAX_TRIED_BYTES = 2048
LOGS = Allowance(5.0, 10)
_LIMITS = HostLinkConfig(max_payload_bytes=512, max_endpoints=MAX_ENDPOINTS)
_TIME_FRAME = encode_frame(ids.TIME, bytes(8))
_TOPIC_KINDS = (ids.PUBLISHER, ids.SUBSCRIBER)
_SERVICE_KINDS = (ids.SERVICE_SERVER_REQUEST, ids.SERVICE_SERVER_RESPONSE)


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


def generate(source: random.Random) -> bytes:
    """Return the data of a board that announces, completes, publishes, floods and is reset, in any order."""
    topics = [_announcement(source, number) for number in range(source.randint(1, MAX_ENDPOINTS + 2))]
    calm = b"".join(step(kind, body, kind=1 | 1 << 1) for kind, body in topics)
    # Each answers a topic request; after enough equal answers, the link considers the list complete.
    script = (step(ids.TIME, bytes(8), kind=1) + calm + step(0, b"", kind=2 << 1)) * source.choice((1, 3, 9))
    for _ in range(source.randint(0, 12)):
        script += _talk(source, topics)
    return script


def _announcement(source: random.Random, number: int) -> tuple[int, bytes]:
    size = source.choice((0, 11, 12, 16, 280, 512, min(near(source, 300), 1 << 21)))
    name = source.choice(("a", "b", f"t{number}"))
    info = TopicInfo(100 + (number if source.random() < 0.8 else 0), name, "std_msgs/String", MD5SUM, size)
    kinds = _TOPIC_KINDS if source.random() < 0.8 else _SERVICE_KINDS
    return source.choice(kinds), info.encode()[:MAX_BODY_BYTES]


def _talk(source: random.Random, topics: list[tuple[int, bytes]]) -> bytes:
    match source.randrange(7):
        case 0:
            return step(ids.TIME, bytes(8)) * source.randint(1, 4)
        case 1:
            return burst(source, ids.TIME, bytes(8))
        case 2:
            return random_step(source, ids.PARAMETER, ParameterRequest("a").encode())
        case 3:
            return burst(source, ids.LOG, Log(LogLevel.INFO, "a").encode())
        case 4:
            size = min(near(source, 280), MAX_BODY_BYTES)
            return random_step(source, 100 + source.randrange(8), bytes(size))
        case 5:
            return random_step(source, *source.choice(topics))
        case _:
            return step(0, b"", kind=source.randrange(4) << 1)


def run(data: bytes) -> None:
    """Feed a script to a link that answers all requests."""
    with lowered(host_output, MAX_WAITING_BYTES=MAX_REPLY_BYTES), lowered(control_rate, LOGS=LOGS):
        _play(data)


def _play(data: bytes) -> None:
    link, now_s = HostLink(_LIMITS), 0.0
    link.start(now_s)
    board = _Board(link)
    logs = times = 0
    for received, pause_s, is_taken in steps(data):
        now_s += pause_s
        board.begin_step()
        # In a negotiation a reset board has already announced its topics.
        was_settled = link.is_settled
        events = [*link.handle_timer(now_s), *link.receive_data(received, now_s)]
        # The link answers with the state of the board after the whole chunk.
        for event in events:
            board.take(event)
        for event in events:
            logs += isinstance(event, LogReceived)
            if isinstance(event, TimeRequested):
                times += 1
                link.answer_time(Time(1, 0), now_s)
            elif isinstance(event, ParameterRequested):
                board.answer_parameter()
        assert logs <= LOGS.burst + LOGS.per_s * now_s + 1, "a board causes more log lines than allowed"
        allowed = control_rate.TIME_REQUESTS
        assert times <= allowed.burst + allowed.per_s * now_s + 1, "more time requests than allowed"
        if was_settled and received == _TIME_FRAME and events and isinstance(events[-1], DeviceReset):
            board.check_reset()
        else:
            board.check_limits()
        if is_taken:
            assert len(link.data_to_send()) <= MAX_REPLY_BYTES, "more bytes wait than allowed"
        due_s = link.get_timer()
        assert due_s is None or math.isfinite(due_s)
    link.stop()


class _Board:
    """The announcements of the board, according to the events."""

    def __init__(self, link: HostLink) -> None:
        self._link = link
        self._topics: dict[tuple[TopicRole, int], TopicInfo] = {}
        self._services: set[tuple[ServiceRole, int, int]] = set()
        self._sent_before: dict[int, int] = {}

    def begin_step(self) -> None:
        """Note the limit of each announced topic; announcements within a step apply from the next one on."""
        self._sent_before = {
            topic_id: info.buffer_size
            for (role, topic_id), info in self._topics.items()
            if role is TopicRole.PUBLISHER
        }

    def take(self, event: HostEvent) -> None:
        """Handle an event."""
        match event:
            case TopicAnnounced(role, info):
                assert info.fault() is None
                self._topics[role, info.topic_id] = info
                self._sent_before.pop(info.topic_id, None)
            case TopicWithdrawn(role, info):
                del self._topics[role, info.topic_id]
                self._sent_before.pop(info.topic_id, None)
            case ServiceAnnounced():
                self._services.add((event.role, event.request.topic_id, event.response.topic_id))
            case ServiceWithdrawn():
                self._services.discard((event.role, event.request.topic_id, event.response.topic_id))
            case MessagesReceived(topic_id, payloads):
                most_bytes = self._sent_before.get(topic_id)
                if most_bytes is not None:
                    assert max(map(len, payloads)) <= most_bytes, "a message larger than its buffer"
            case _:
                pass

    def check_limits(self) -> None:
        """Check the number of endpoints, and that only messages that fit a buffer are sent."""
        assert len(self._topics) + 2 * len(self._services) <= MAX_ENDPOINTS, "more endpoints than allowed"
        for (role, topic_id), info in self._topics.items():
            size = info.buffer_size
            if role is TopicRole.PUBLISHER or size > MAX_TRIED_BYTES or not self._can_send(topic_id):
                continue
            self._link.encode_message(topic_id, bytes(size))
            try:
                self._link.encode_messages(topic_id, [b"", bytes(size + 1)])
            except LocalProtocolError as error:
                assert "\n" not in str(error)
            else:
                raise AssertionError("a message went out that is larger than the board's buffer")

    def check_reset(self) -> None:
        """Check that nothing is sent to a board that was reset and has announced nothing since."""
        assert not any(map(self._can_send, range(100, 256))), "sends to a board that was just reset"

    def _can_send(self, topic_id: int) -> bool:
        try:
            self._link.encode_messages(topic_id, ())
        except LocalProtocolError:
            return False
        return True

    def answer_parameter(self) -> None:
        """Answer like the bridge: empty if the value does not fit, not at all if that does not fit either."""
        buffers = [
            info.buffer_size for (role, _), info in self._topics.items() if role is TopicRole.SUBSCRIBER
        ]
        for ints, size in (((1,), 16), ((), 12)):
            try:
                self._link.answer_parameter(ints)
            except LocalProtocolError as error:
                assert "\n" not in str(error)
            else:
                assert size <= min(buffers, default=size), "an answer larger than the board's buffer"
                return
