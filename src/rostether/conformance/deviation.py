"""The finding of a failed check."""

from __future__ import annotations


class Deviation(Exception):  # noqa: N818 - a finding, not an error of this program
    """A difference between the client's behavior and the requirement of a case."""
