"""Findings about single topics and services of a board."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from weakref import WeakKeyDictionary

from rostether.bridge.endpoint.openings import Endpoint, ServiceEndpoint, name_of
from rostether.bridge.endpoint.publisher import PublisherEndpoint
from rostether.bridge.endpoint.subscriber import SubscriberEndpoint
from rostether.bridge.endpoint.table import EndpointTable
from rostether.bridge.findings.finding import Code, Finding, error, split_step, warning
from rostether.bridge.findings.oversize import Oversizes
from rostether.errors import DefinitionError, RostetherError, TypeMismatchError, UnknownTypeError
from rostether.mechanisms.text import listed
from rostether.rosserial.events import ServiceRole
from rostether.rosserial.packets import PUBLISHER_OVERHEAD_BYTES, TopicInfo
from rostether.serde.store import TypeStore

# How long a loss is reported after it happened.
RECENT_S = 30.0

# One damaged frame in 256 passes the checksum; more misfits than this mean another definition.
MIN_MISFITS = 3
MISFIT_SHARE = 0.05

# More would not fit on a line.
_LISTED_TOPICS = 6

_LARGER = "enlarge it in the sketch: ros::NodeHandle_<ArduinoHardware, 25, 25, INPUT, OUTPUT>, in bytes"


class EndpointFindings:
    """Judges the endpoints of one board."""

    def __init__(self, endpoints: EndpointTable, store: TypeStore) -> None:
        self._endpoints = endpoints
        self._store = store
        # The number of dropped messages at the last check, and when it last increased.
        self._losses: WeakKeyDictionary[SubscriberEndpoint, tuple[int, float]] = WeakKeyDictionary()

    def find(self, now_s: float, too_large_s: float, oversizes: Oversizes) -> list[Finding]:
        """Return the findings; at `too_large_s`, the board reported that its own message was too large."""
        found = _refusals(self._endpoints.refused)
        for name, reason in self._endpoints.unopened.items():
            seen, step = split_step(f"{name} is not bridged: {reason}", "read the log of this program")
            found.append(error(Code.NOT_BRIDGED, seen, step, name, is_reported=True))
        silent = []
        for _, endpoint in self._endpoints:
            found += self._too_long(endpoint, oversizes, now_s)
            if isinstance(endpoint, PublisherEndpoint):
                found += self._publisher(endpoint)
                if not endpoint.message_count:
                    silent.append(endpoint)
            elif isinstance(endpoint, SubscriberEndpoint):
                found += self._subscriber(endpoint, now_s)
        if now_s - too_large_s < RECENT_S and not any(each.code is Code.BUFFER_TOO_SMALL for each in found):
            found.append(_too_large(silent))
        return found

    def _too_long(self, endpoint: Endpoint, oversizes: Oversizes, now_s: float) -> Iterator[Finding]:
        info = _sent_by_board(endpoint)
        seen = oversizes.of(info.topic_id, now_s) if info is not None else None
        if info is None or seen is None:
            return
        if seen.largest_bytes <= info.buffer_size:
            # A streaming board announces no buffer; the size of the type counts.
            reason = "more than this type or the limit of the frame length allows"
            step = "generate the message headers of the sketch again, and publish nothing else on this topic"
        else:
            reason = f"and the board announced a buffer of {info.buffer_size}"
            step = f"{_LARGER}, or send smaller messages"
        yield error(
            Code.MESSAGES_TOO_LONG,
            f"messages of {info.topic_name} [{info.message_type}] have {seen.largest_bytes} bytes, "
            f"{reason}: they are rejected",
            step,
            info.topic_name,
        )

    def _publisher(self, endpoint: PublisherEndpoint) -> Iterator[Finding]:
        info = endpoint.info
        needed = self._store.layout(info.message_type).smallest_size_bytes + PUBLISHER_OVERHEAD_BYTES
        if needed > info.buffer_size:
            yield error(
                Code.BUFFER_TOO_SMALL,
                f"no message of {info.topic_name} [{info.message_type}] fits: it needs at least "
                f"{needed} bytes, but the board's output buffer has {info.buffer_size}",
                _LARGER,
                info.topic_name,
            )
        misfits = endpoint.misfit_count
        if misfits >= MIN_MISFITS and misfits > MISFIT_SHARE * (misfits + endpoint.message_count):
            yield error(
                Code.MESSAGES_MISFIT,
                f"{misfits} messages of {info.topic_name} do not have the layout of {info.message_type} "
                "and were dropped",
                "generate the message headers of the sketch again, and set the _length of every array",
                info.topic_name,
            )

    def _subscriber(self, endpoint: SubscriberEndpoint, now_s: float) -> Iterator[Finding]:
        info = endpoint.info
        smallest_bytes = self._store.layout(info.message_type).smallest_size_bytes
        largest = max(endpoint.largest_oversize_bytes, smallest_bytes)
        if largest > info.buffer_size:
            yield error(
                Code.BUFFER_TOO_SMALL,
                f"messages of {info.topic_name} [{info.message_type}] have {largest} bytes, but the "
                f"board's input buffer has only {info.buffer_size}: they are not sent",
                f"{_LARGER}, or send smaller messages",
                info.topic_name,
                is_reported=endpoint.largest_oversize_bytes > 0,
            )
        count, changed_s = self._losses.get(endpoint, (0, float("-inf")))
        if endpoint.dropped_count > count:
            changed_s = now_s
        self._losses[endpoint] = endpoint.dropped_count, changed_s
        if now_s - changed_s < RECENT_S:
            yield warning(
                Code.MESSAGES_LOST,
                f"{info.topic_name} is faster than the board can receive: {endpoint.dropped_count} of "
                "its messages were dropped, the oldest first",
                "publish it less often, or choose a higher baud rate",
                info.topic_name,
                is_reported=True,
            )


def _sent_by_board(endpoint: Endpoint) -> TopicInfo | None:
    """Return the announcement of the messages that the board sends; a service has one per direction."""
    if isinstance(endpoint, PublisherEndpoint):
        return endpoint.info
    if isinstance(endpoint, ServiceEndpoint):
        info = endpoint.info
        return info.response if info.role is ServiceRole.SERVER else info.request
    return None


def _refusals(refused: dict[str, RostetherError]) -> list[Finding]:
    """Return one finding for each cause: several topics may have the same stale type."""
    names: defaultdict[tuple[type[RostetherError], str], list[str]] = defaultdict(list)
    for name, reason in refused.items():
        names[type(reason), str(reason)].append(name)
    return [_refusal(kind, text, topics) for (kind, text), topics in names.items()]


def _refusal(kind: type[RostetherError], text: str, topics: list[str]) -> Finding:
    names = listed(topics, _LISTED_TOPICS)
    unbridged = f"{names} {'is' if len(topics) == 1 else 'are'} not bridged"
    if issubclass(kind, TypeMismatchError):
        reason, step = split_step(text, "generate its message headers again")
        seen = f"the sketch's message headers for {names} are stale: {reason}"
        return error(Code.STALE_HEADERS, seen, step, text.partition(":")[0], is_reported=True)
    code, default = Code.NOT_BRIDGED, "correct it in the sketch"
    if issubclass(kind, UnknownTypeError):
        code, default = Code.UNKNOWN_TYPE, "give its package with --msg-path DIR"
    elif issubclass(kind, DefinitionError):
        default = "correct the definition"
    reason, step = split_step(text, default)
    return error(code, f"{unbridged}: {reason}", step, topics[0], is_reported=True)


def _too_large(silent: list[PublisherEndpoint]) -> Finding:
    names = ", ".join(f"{name_of(each)} [{each.info.message_type}]" for each in silent[:4])
    which = f", so nothing arrived on {names}" if names else ""
    size = f" of {silent[0].info.buffer_size} bytes" if silent else ""
    return error(
        Code.BUFFER_TOO_SMALL,
        f"the board dropped a message that is larger than its output buffer{size}{which}",
        _LARGER,
        silent[0].info.topic_name if silent else "",
    )
