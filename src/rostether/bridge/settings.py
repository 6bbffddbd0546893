"""The limits of the bridge that a user may want to set, with the reason for each default."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct, field


class BridgeSettings(Struct, frozen=True):
    """The limits of one bridge, or of one board.

    `grace_s`: how long a lost board's node and topics stay in the graph. A reset, a USB re-enumeration or a
    Wi-Fi re-association is over within 5 s, and subscribers then never notice it.
    `service_timeout_s`: how long a caller waits for a board's service. A board that is busy for 11 s loses
    its configuration, so no working service takes longer than 10 s.
    `client_call_timeout_s`: how long a board's own call may take in the graph. The board gets no time answer
    meanwhile, and unconfigures itself without one after 11 s.
    `queued_calls`: how many callers may wait for one board's service before the next is refused immediately.
    `parameter_timeout_s`: how long a parameter is searched. A board waits 1 s for it, unless the sketch sets
    another limit.
    `drain_pause_s`: how long a board is paused at a time for a slow subscriber.
    `frame_bytes`: the largest payload of a frame from a board; the default is the largest value of the
    length field.
    `endpoints`: how many a board may announce. The established library has at most 50.
    `messages_hz`: how many messages per second a board may publish, on all topics together (None: as many as
    its line can transfer).
    `queue_bytes`: how much data may wait for a board on each topic: more than one read of a ROS connection.
    On a line with a baud rate, the limit is lower.
    `subscriber_bytes`: how much data may wait for a slow ROS subscriber of a board's topic: a second of
    images.
    `unsent_bytes`: how many bytes may wait in a link that accepts nothing; beyond it, responses are dropped.
    `connections`, `connections_per_host`: how many boards may connect to one listener, and from one address
    (None: the default of the kind of link).
    `stall_s`: how long a board may accept no byte before its subscriptions no longer wait for it.
    """

    grace_s: float = 5.0
    service_timeout_s: float = 10.0
    client_call_timeout_s: float = 8.0
    queued_calls: int = 32
    parameter_timeout_s: float = 0.8
    drain_pause_s: float = 0.1
    stall_s: float = 1.0
    frame_bytes: int = 65535
    endpoints: int = 256
    messages_hz: float | None = None
    queue_bytes: int = 128 * 1024
    subscriber_bytes: int = 4 * 1024 * 1024
    unsent_bytes: int = 1024 * 1024
    connections: int | None = None
    connections_per_host: int | None = None


DEFAULT_SETTINGS = BridgeSettings()


class BoardNodes(Struct, frozen=True):
    """How the nodes of boards join the graph.

    `ns_per_board`: a board's topics go into a namespace of its name, unless its address has `ns=`.
    `keeps_node`: there is one address, which has a `name=`. Its node exists from the start, even without a
    board; when it is shut down from outside, the bridge ends.
    `diagnostics`: each board's node publishes /diagnostics.
    """

    ns_per_board: bool = False
    keeps_node: bool = False
    remappings: Mapping[str, str] = field(default_factory=dict)
    diagnostics: bool = False


DEFAULT_NODES = BoardNodes()
