"""The interface of `rostether topic` to a graph, its requests, and the choice between ROS 1 and ROS 2."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from rostether.cli.access.graph_options import GraphOptions

if TYPE_CHECKING:
    from rostether.cli.topic.meter import TopicMeter


class Topics(Protocol):
    """The topics of one graph. Each method is a whole command and raises RostetherError, UsageError."""

    def list_topics(self, wanted: TopicListing) -> None:
        """Print the topics."""

    def info(self, topic: str, *, verbose: bool, as_json: bool) -> None:
        """Print a topic's type, publishers and subscribers."""

    def type_of(self, topic: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the type of a topic, or of a field in it."""

    def find(self, type_name: str, *, with_hidden: bool, as_json: bool) -> None:
        """Print the topics of a type."""

    def echo(self, topic: str, type_name: str | None, options: EchoOptions) -> None:
        """Print messages as they arrive."""

    def publish(self, topic: str, type_name: str, values: tuple[str, ...], options: PubOptions) -> None:
        """Publish messages."""

    def meter(
        self, topics: tuple[str, ...], msg_paths: tuple[Path, ...], *, quiet: bool, needs_definitions: bool
    ) -> AbstractAsyncContextManager[TopicMeter]:
        """Join the graph and wait for the topics; `quiet` leaves out the lines about that.

        Definitions are needed only to decode messages.
        """


def topics_of(graph: GraphOptions) -> Topics:
    """Return the topics of the graph that a command means."""
    if graph.ros2 is None:
        from rostether.cli.topic.ros1_topics import Ros1Topics

        return Ros1Topics(graph)
    from rostether.cli.topic.ros2_topics import Ros2Topics

    return Ros2Topics(graph)


@dataclass(frozen=True, slots=True)
class TopicListing:
    """The options of `topic list`."""

    namespace: str | None = None
    verbose: bool = False
    publishers: bool = False
    subscribers: bool = False
    by_host: bool = False
    show_types: bool = False
    count_topics: bool = False
    with_hidden: bool = False
    as_json: bool = False


@dataclass(frozen=True, slots=True)
class EchoOptions:
    """The options of `topic echo`; `filter` decides which messages are shown."""

    count: int | None = None
    once: bool = False
    plot: bool = False
    as_json: bool = False
    clear: bool = False
    noarr: bool = False
    nostr: bool = False
    number_width: int | None = None
    offset: bool = False
    expression: str | None = None
    field: str = ""
    csv: bool = False
    full_length: bool = False
    truncate_length: int | None = None
    flow_style: bool = False
    timeout_s: float | None = None
    msg_paths: tuple[Path, ...] = ()

    @property
    def wanted_count(self) -> int | None:
        """How many messages to show, None without a limit."""
        return 1 if self.once else self.count

    def compiled_filter(self) -> Callable[[object, str], bool] | None:
        """Return the filter, None to show all messages. Raises ConfigError for a wrong expression."""
        if self.expression is None:
            return None
        from rostether.expression.compiler import compile_filter

        return compile_filter(self.expression)


@dataclass(frozen=True, slots=True)
class PubOptions:
    """The options of `topic pub`."""

    once: bool = False
    rate_hz: float | None = None
    latch: bool = False
    file: Path | None = None
    substitute_keywords: bool = False
    use_rostime: bool = False
    verbose: bool = False
    times: int = 0
    wait_for: int | None = None
    max_wait_s: float | None = None
    print_nth: int | None = None
    qos_durability: str | None = None
    msg_paths: tuple[Path, ...] = ()
