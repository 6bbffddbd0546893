"""Delays and rates of transforms, for each frame and for each node that broadcasts them."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from msgspec import Struct, field

from rostether.robot.transform import StampedTransform
from rostether.rostime import NS_PER_S

# The number of delays that are averaged, as in tf_monitor.
WINDOW = 1_000

# Peers choose the names of frames and nodes; the limit is the same as in a buffer.
MAX_ROWS = 10_000


class Delays(Struct):
    """The last delays of one frame or node, in seconds, and the arrival times of its messages."""

    delays_s: deque[float] = field(default_factory=lambda: deque(maxlen=WINDOW))
    arrivals_ns: deque[int] = field(default_factory=lambda: deque(maxlen=WINDOW))
    broadcaster: str = ""

    def add(self, delay_s: float, now_ns: int) -> None:
        """Add the delay and the arrival time of one message."""
        self.delays_s.append(delay_s)
        self.arrivals_ns.append(now_ns)

    @property
    def average_s(self) -> float:
        """The mean delay."""
        return sum(self.delays_s) / len(self.delays_s) if self.delays_s else 0.0

    @property
    def max_s(self) -> float:
        """The longest delay."""
        return max(self.delays_s, default=0.0)

    @property
    def rate_hz(self) -> float:
        """Messages per second; zero after only one message."""
        if len(self.arrivals_ns) < 2:
            return 0.0
        span_ns = self.arrivals_ns[-1] - self.arrivals_ns[0]
        return (len(self.arrivals_ns) - 1) * NS_PER_S / span_ns if span_ns > 0 else 0.0


class TfStatistics:
    """Counts the transforms of a listener; a static transform has no delay."""

    def __init__(self) -> None:
        self.frames: dict[str, Delays] = {}
        self.nodes: dict[str, Delays] = {}

    def add(
        self, transforms: Sequence[StampedTransform], authority: str, is_static: bool, now_ns: int
    ) -> None:
        """Count a message with at least one transform; the mean of its delays is the delay of the node."""
        delays_s = [0.0 if is_static else (now_ns - each.stamp_ns) / NS_PER_S for each in transforms]
        for stamped, delay_s in zip(transforms, delays_s, strict=True):
            _add(self.frames, stamped.child.removeprefix("/"), delay_s, now_ns, authority)
        _add(self.nodes, authority, sum(delays_s) / len(delays_s), now_ns, authority)


def _add(table: dict[str, Delays], key: str, delay_s: float, now_ns: int, authority: str) -> None:
    if key in table or len(table) < MAX_ROWS:
        row = table.setdefault(key, Delays())
        row.add(delay_s, now_ns)
        row.broadcaster = authority
