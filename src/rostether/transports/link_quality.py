"""How well one board's radio link works, counted by the radio at the host."""

from __future__ import annotations

from collections import deque

from msgspec import Struct, field

# The loss is measured over this many of the last packets: a few seconds of a busy link, and enough that one
# lost packet has little weight.
RECENT_PACKETS = 50
# If all packets were lost, this many are enough.
UNREACHED_PACKETS = 10


class LinkQuality(Struct):
    """Counts since the host opened the radio.

    `rssi_dbm`: the signal strength of the last packet from the board, None if unknown. `retries` is None if
    the radio does not count them.
    """

    rssi_dbm: int | None = None
    received_packets: int = 0
    sent_packets: int = 0
    lost_packets: int = 0
    retries: int | None = None
    last_status: str = "none"
    # The result of the last packet that was lost.
    last_loss: str = ""
    _recent: deque[bool] = field(default_factory=lambda: deque(maxlen=RECENT_PACKETS))

    def count_received(self, rssi_dbm: int | None) -> None:
        """Count a packet from the board."""
        self.received_packets += 1
        if rssi_dbm is not None:
            self.rssi_dbm = rssi_dbm

    def count_sent(self, status: str, *, is_lost: bool, retries: int | None = None) -> None:
        """Count a packet to the board, with its result in words."""
        self.sent_packets += 1
        self.lost_packets += is_lost
        self._recent.append(is_lost)
        self.last_status = status
        if is_lost:
            self.last_loss = status
        if retries is not None:
            self.retries = (self.retries or 0) + retries

    @property
    def recent_packets(self) -> int:
        """How many packets `recent_loss` counts."""
        return len(self._recent)

    @property
    def recent_loss(self) -> float | None:
        """The lost share of the last packets to the board, from 0 to 1; None until there are enough."""
        count = len(self._recent)
        is_enough = count == RECENT_PACKETS or (count >= UNREACHED_PACKETS and all(self._recent))
        return sum(self._recent) / count if is_enough else None
