"""The exceptions of tf and tf2."""

from __future__ import annotations


class TransformException(Exception):
    """The base of the errors of a lookup."""


class ConnectivityException(TransformException):
    """The two frames are in different trees."""


class LookupException(TransformException):
    """A frame was never published, or the frames form a loop."""


class ExtrapolationException(TransformException):
    """The time is before or after the known transforms."""


class InvalidArgumentException(TransformException):
    """A frame's name or a quaternion is invalid."""


class TimeoutException(TransformException):
    """The answer was too late."""


class TypeException(Exception):
    """No transformation is registered for the type."""

    def __init__(self, errstr: str) -> None:
        super().__init__(errstr)
        self.errstr = errstr


class NotImplementedException(Exception):
    """The buffer cannot look up transforms."""
