"""The possible lengths of a device's payloads, from its announcements."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct, field


class PayloadLimits(Struct, frozen=True):
    """The longest plausible payload of each topic id, and the length above which a header is noise.

    `refused_above` has the limit of all other ids under None.
    """

    possible: Mapping[int, int] = field(default_factory=dict)
    refused_above: Mapping[int | None, int] = field(default_factory=dict)


NO_LIMITS = PayloadLimits()
