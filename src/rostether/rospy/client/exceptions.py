"""The exceptions of rospy, under the names that programs catch."""

from __future__ import annotations


class ROSException(Exception):
    """The base of the errors that rospy raises in programs."""


class MasterAwayException(ROSException, ConnectionRefusedError):
    """No master answers at the address; programs catch it as the error of a socket, as in rospy."""


class ROSSerializationException(ROSException):
    """The values of a message do not fit its type."""


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
    """The base of errors inside rospy."""


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
