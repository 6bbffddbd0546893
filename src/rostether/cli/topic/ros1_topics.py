"""`rostether topic` on a ROS 1 graph."""

from __future__ import annotations

from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.refusals import refuse_ros2_only
from rostether.cli.topic.requests import EchoOptions, PubOptions, TopicListing

if TYPE_CHECKING:
    from rostether.cli.topic.meter import TopicMeter


class Ros1Topics:
    """The topics of a ROS 1 graph."""

    def __init__(self, graph: GraphOptions) -> None:
        self._graph = graph

    def list_topics(self, wanted: TopicListing) -> None:
        """Print the topics."""
        from rostether.cli.topic.ros1_listing import list_topics

        list_topics(self._graph, wanted)

    def info(self, topic: str, *, verbose: bool, as_json: bool) -> None:
        """Print a topic's type, and the nodes that publish and subscribe to it."""
        from rostether.cli.topic.ros1_listing import info

        refuse_ros2_only(verbose=verbose)
        info(self._graph, topic, as_json=as_json)

    def type_of(self, topic: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the type of a topic, or of a field in it."""
        from rostether.cli.topic.ros1_listing import type_of

        type_of(self._graph, topic, msg_paths)

    def find(self, type_name: str, *, with_hidden: bool, as_json: bool) -> None:
        """Print the topics of a type."""
        from rostether.cli.topic.ros1_listing import find

        find(self._graph, type_name, as_json=as_json)

    def echo(self, topic: str, type_name: str | None, options: EchoOptions) -> None:
        """Print messages as rostopic does."""
        from rostether.cli.topic.ros1_echo import echo

        refuse_ros2_only(
            type_name=type_name,
            field=options.field,
            csv=options.csv,
            full_length=options.full_length,
            truncate_length=options.truncate_length,
            flow_style=options.flow_style,
            timeout_s=options.timeout_s,
        )
        echo(self._graph, topic, options)

    def publish(self, topic: str, type_name: str, values: tuple[str, ...], options: PubOptions) -> None:
        """Publish messages as rostopic does."""
        from rostether.cli.topic.ros1_pub import publish

        refuse_ros2_only(
            times=options.times,
            wait_for=options.wait_for is not None,
            max_wait_s=options.max_wait_s,
            print_nth=options.print_nth is not None,
            qos_durability=options.qos_durability,
        )
        publish(self._graph, topic, type_name, values, options)

    def meter(
        self, topics: tuple[str, ...], msg_paths: tuple[Path, ...], *, quiet: bool, needs_definitions: bool
    ) -> AbstractAsyncContextManager[TopicMeter]:
        """Join the graph and wait for the topics; `quiet` leaves out the lines about that."""
        from rostether.cli.topic.meter import ros1_meter

        return ros1_meter(self._graph, topics, msg_paths, quiet=quiet)
