"""How long the payloads of a device can be, as far as it has announced them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class PayloadLimits:
    """By topic id: the longest plausible payload, and the length above which a header is noise.

    `refused_above` has the limit of every other id under None.
    """

    possible: Mapping[int, int] = field(default_factory=dict)
    refused_above: Mapping[int | None, int] = field(default_factory=dict)


NO_LIMITS = PayloadLimits()
