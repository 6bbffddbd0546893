"""The errors of rosbag's Python."""

from __future__ import annotations

from typing import Any


class ROSBagException(Exception):  # noqa: N818 - the name is rosbag's
    """The base of rosbag's errors."""

    def __init__(self, value: str | None = None) -> None:
        self.value = value
        super().__init__(value)

    def __str__(self) -> str:
        return str(self.value)


class ROSBagFormatException(ROSBagException):
    """The file is not a bag, or is damaged."""


class ROSBagUnindexedException(ROSBagException):
    """The bag was not closed."""

    def __init__(self, *args: Any) -> None:
        super().__init__("Unindexed bag")
