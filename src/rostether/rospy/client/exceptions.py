"""The exceptions that rospy's users catch, under rospy's names."""

# ruff: noqa: N818 - the names are rospy's

from __future__ import annotations


class ROSException(Exception):
    """Anything that rospy reports to its user."""


class MasterAwayException(ROSException, ConnectionRefusedError):
    """No master answers at the address; rospy raises the error of the socket here."""


class ROSSerializationException(ROSException):
    """A message whose values do not fit its type."""


class ROSInitException(ROSException):
    """The node cannot start, or is used before init_node."""


class ROSInterruptException(ROSException, KeyboardInterrupt):
    """The node was shut down while something waited."""


class ROSTimeMovedBackwardsException(ROSInterruptException):
    """ROS time went back during a sleep; `time` is the jump in seconds."""

    def __init__(self, time: float) -> None:
        self.time = time
        super().__init__("ROS time moved backwards")


class ROSInternalException(Exception):
    """The base of errors that rospy does not show to its users."""


class TransportException(ROSInternalException):
    """A connection failed."""


class TransportTerminated(TransportException):
    """A connection broke."""


class TransportInitError(TransportException):
    """A connection could not be made."""


class ServiceException(Exception):
    """A service call failed, or a handler cannot answer."""


class ParameterInvalid(Exception):
    """An invalid argument."""
