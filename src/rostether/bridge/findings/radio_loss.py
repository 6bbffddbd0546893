"""Finds a board whose radio does not acknowledge what is sent to it."""

from __future__ import annotations

from rostether.bridge.findings.finding import Code, Finding, warning
from rostether.transports.xbee.link_quality import RECENT_PACKETS, LinkQuality

# The radio has repeated each of these packets several times, so a link with fewer losses is still usable.
_MUCH_LOSS = 0.1


def find_radio_loss(radio: LinkQuality | None) -> list[Finding]:
    """Return the finding, if the board's radio link loses many packets."""
    loss = radio.recent_loss if radio is not None else None
    if radio is None or loss is None or loss < _MUCH_LOSS:
        return []
    signal = "" if radio.rssi_dbm is None else f", signal {radio.rssi_dbm} dBm"
    return [
        warning(
            Code.RADIO_LOSS,
            f"{loss:.0%} of the last {RECENT_PACKETS} radio packets to the board were lost "
            f"({radio.last_status}{signal})",
            "move the radios closer together, or set all of them to another channel",
        )
    ]
