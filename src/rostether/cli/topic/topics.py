"""What `rostether topic` needs of a graph, and the choice between ROS 1 and ROS 2."""

from __future__ import annotations

from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from rostether.cli.access.graph_options import GraphOptions

if TYPE_CHECKING:
    from rostether.cli.topic.meter import TopicMeter
    from rostether.cli.topic.options import EchoOptions, PubOptions, TopicListing


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
        """Join the graph and wait for the topics; `quiet` omits the progress lines.

        Without `needs_definitions`, the meter only gets undecoded messages.
        """


def topics_of(graph: GraphOptions) -> Topics:
    """Return the topics of the graph that the command line selects."""
    if graph.ros2 is None:
        from rostether.cli.topic.ros1_topics import Ros1Topics

        return Ros1Topics(graph)
    from rostether.cli.topic.ros2_topics import Ros2Topics

    return Ros2Topics(graph)
