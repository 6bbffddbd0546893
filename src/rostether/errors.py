"""All errors of rostether. Each text is one sentence: what was wrong, and what to do.

RostetherError
├── InvalidNameError            a graph name, package name or type name that breaks the naming rules
├── ConfigError                 an option, link address, environment variable or file that is not valid
├── LaunchError                 a launch file that cannot be understood or started (file, line)
├── CodegenError                a client library that cannot be generated
├── FirmwareError               a sketch that cannot be built, measured or uploaded
│   └── SketchError             the compiler or the linker rejects it; has their output
├── RobotModelError             a robot description (URDF, xacro) that is not valid
├── BoardError                  a simulated board that cannot start, refuses a command, or has ended
├── SensorError                 a sensor, such as a camera, that is missing or whose data cannot be used
├── DefinitionError             a .msg or .srv text that cannot be read (file, line, column)
│   └── UnknownTypeError        no known package has the message or service
├── SerializationError          a value or bytes that do not fit a type
├── ProtocolError
│   ├── LocalProtocolError      the program wanted to send something that the protocol does not allow
│   └── RemoteProtocolError     the peer sent something that the protocol does not allow
├── TransportError
│   ├── TransportOpenError      a port, address or pseudo-terminal that cannot be opened
│   ├── TransportClosedError    the connection ended: unplugged, or closed by either side
│   │   └── PeerClosedError     the peer closed the connection cleanly
│   └── TransportTimeoutError   the peer did not answer in time
├── GraphError
│   ├── MasterUnreachableError  no ROS master answers
│   ├── UnknownNameError        the graph knows no such topic, node, service or parameter
│   ├── TypeMismatchError       both ends disagree on a type or its md5sum
│   ├── AccessDeniedError       the user's lists do not let a board use a name
│   └── ServiceCallError
│       ├── ServiceUnavailableError
│       └── ServiceTimeoutError
├── RecordingError              a recording that cannot be read or written
├── TransformError              tf cannot compute the transform between two frames
│   ├── UnknownFrameError       no node has published the frame, or the frames form a loop
│   ├── UnconnectedFramesError  no path of transforms leads from one frame to the other
│   └── ExtrapolationError      the requested time is outside the received transforms
└── SessionError                the session of one board cannot continue
    └── NodeEndedError          another program shut down the board's node
"""

from __future__ import annotations


def first_error(error: BaseException) -> BaseException:
    """Return the first error of a group, such as a task group raises, or the error itself."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error


class RostetherError(Exception):
    """The base of all errors that rostether raises on purpose; its text is one line for users."""


class InvalidNameError(RostetherError, ValueError):
    """A graph resource name, package name or type name breaks the naming rules."""


class ConfigError(RostetherError):
    """A setting is not valid: option, link address, environment variable or file."""


class LaunchError(RostetherError):
    """A launch file cannot be understood or started; `line` counts from 1; 0 is unknown."""

    def __init__(self, message: str, *, file: str = "", line: int = 0) -> None:
        location = ":".join(str(part) for part in (file, line) if part)
        super().__init__(f"{location}: {message}" if location else message)
        self.file = file
        self.line = line


class CodegenError(RostetherError):
    """A client library cannot be generated."""


class FirmwareError(RostetherError):
    """A sketch cannot be built, measured or uploaded."""


class SketchError(FirmwareError):
    """The compiler or the linker rejects a sketch; `diagnostics` is their output."""

    def __init__(self, message: str, *, diagnostics: str) -> None:
        super().__init__(message)
        self.diagnostics = diagnostics


class RobotModelError(RostetherError):
    """A robot description cannot be read; the text names the line and the link or joint."""


class BoardError(RostetherError):
    """A simulated board cannot start, refuses a command, or has ended."""


class SensorError(RostetherError):
    """A sensor, such as a camera, is missing, or its data cannot be used."""


class DefinitionError(RostetherError):
    """A message or service definition cannot be read; `line` and `column` count from 1; 0 is unknown."""

    def __init__(self, message: str, *, file: str = "", line: int = 0, column: int = 0) -> None:
        location = ":".join(str(part) for part in (file, line, column) if part)
        super().__init__(f"{location}: {message}" if location else message)
        self.file = file
        self.line = line
        self.column = column


class UnknownTypeError(DefinitionError, LookupError):
    """No known package has the message or service."""


class SerializationError(RostetherError, ValueError):
    """A value does not fit its type, or bytes do not have their type's layout."""


class ProtocolError(RostetherError):
    """A protocol was violated."""


class LocalProtocolError(ProtocolError):
    """The program wanted to send something that the protocol does not allow."""


class RemoteProtocolError(ProtocolError):
    """The peer sent what the protocol does not allow."""


class TransportError(RostetherError):
    """A connection to a device failed."""


class TransportOpenError(TransportError):
    """A port, address or pseudo-terminal cannot be opened."""


class TransportClosedError(TransportError):
    """The connection ended: unplugged, or closed by either side."""


class PeerClosedError(TransportClosedError):
    """The peer closed the connection cleanly, as a program does at its end; a board that resets cannot."""


class TransportTimeoutError(TransportError, TimeoutError):
    """The peer did not answer in time."""


class GraphError(RostetherError):
    """A ROS graph refused or failed a request."""


class MasterUnreachableError(GraphError):
    """No ROS master answers at the address."""


class UnknownNameError(GraphError, LookupError):
    """The graph has no such topic, node, service or parameter."""


class TypeMismatchError(GraphError):
    """Two ends disagree on a type or on its md5sum."""


class AccessDeniedError(GraphError):
    """The user's allow and deny lists do not let a board use a topic, service or parameter."""


class ServiceCallError(GraphError):
    """A service call failed; the text is the server's if it sent one."""


class ServiceUnavailableError(ServiceCallError):
    """No node offers the service, or its server does not answer."""


class ServiceTimeoutError(ServiceCallError, TimeoutError):
    """The service did not respond within the time limit."""


class RecordingError(RostetherError):
    """A recording cannot be read, or cannot be written to the disk."""


class TransformError(RostetherError):
    """The transform between two frames cannot be computed."""


class UnknownFrameError(TransformError, LookupError):
    """No node has published the frame, or the frames form a loop."""


class UnconnectedFramesError(TransformError):
    """No path of transforms leads from one frame to the other."""


class ExtrapolationError(TransformError):
    """The requested time is outside the received transforms."""


class SessionError(RostetherError):
    """The session of one board cannot continue."""


class NodeEndedError(SessionError):
    """Another program shut down the board's node; the board is served again after it reconnects."""
