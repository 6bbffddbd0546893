"""`rostether topic` on a ROS 2 graph."""

from __future__ import annotations

from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.refusals import refuse_ros1_only
from rostether.cli.topic.requests import EchoOptions, PubOptions, TopicListing

if TYPE_CHECKING:
    from rostether.cli.topic.meter import TopicMeter


class Ros2Topics:
    """The topics of a ROS 2 graph."""

    def __init__(self, graph: GraphOptions) -> None:
        refuse_ros1_only(master=graph.master)
        self._graph = graph

    def list_topics(self, wanted: TopicListing) -> None:
        """Print the topics."""
        from rostether.cli.topic.ros2_listing import list_topics

        refuse_ros1_only(by_host=wanted.by_host)
        list_topics(self._graph, wanted)

    def info(self, topic: str, *, verbose: bool, as_json: bool) -> None:
        """Print a topic's type and how many publish and subscribe; each of them with `verbose`."""
        from rostether.cli.topic.ros2_listing import info

        info(self._graph, topic, verbose=verbose, as_json=as_json)

    def type_of(self, topic: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the type of a topic."""
        from rostether.cli.topic.ros2_listing import type_of

        type_of(self._graph, topic)

    def find(self, type_name: str, *, with_hidden: bool, as_json: bool) -> None:
        """Print the topics of a type."""
        from rostether.cli.topic.ros2_listing import find

        find(self._graph, type_name, as_json=as_json, with_hidden=with_hidden)

    def echo(self, topic: str, type_name: str | None, options: EchoOptions) -> None:
        """Print messages as `ros2 topic echo` does."""
        from rostether.cli.topic.ros2_echo import echo

        refuse_ros1_only(plot=options.plot, number_width=options.number_width, offset=options.offset)
        echo(self._graph, topic, type_name, options)

    def publish(self, topic: str, type_name: str, values: tuple[str, ...], options: PubOptions) -> None:
        """Publish messages as `ros2 topic pub` does."""
        from rostether.cli.topic.ros2_pub import publish

        refuse_ros1_only(substitute_keywords=options.substitute_keywords, use_rostime=options.use_rostime)
        publish(self._graph, topic, type_name, values, options)

    def meter(
        self, topics: tuple[str, ...], msg_paths: tuple[Path, ...], *, quiet: bool, needs_definitions: bool
    ) -> AbstractAsyncContextManager[TopicMeter]:
        """Join the graph and wait for the topics; `quiet` leaves out the lines about that."""
        from rostether.cli.topic.meter import ros2_meter

        return ros2_meter(self._graph, topics, msg_paths, quiet=quiet, needs_definitions=needs_definitions)
