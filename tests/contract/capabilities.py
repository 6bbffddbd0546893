"""The differences between implementations of the graph port; everything else is the same for all."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What an implementation supports; the defaults are those of ROS 1."""

    # All nodes share one tree of parameters; otherwise each parameter belongs to a node.
    global_parameters: bool = True
    # A parameter may be a list of values of different types.
    mixed_lists: bool = True
    # A node that joins with the name of another node ends that node; otherwise both stay.
    same_name_replaces: bool = True
    # The last server of a service replaces the earlier one; otherwise both serve it.
    last_server_wins: bool = True
    # The answer to a failed call has the text of the error; otherwise there is no answer, and the server logs
    # the error.
    sends_service_errors: bool = True
    # A publisher notices that a subscriber on another node does not read.
    detects_slow_subscribers: bool = True
    # A subscriber receives the publisher's definition and md5sum; otherwise it uses its own definition of the
    # type.
    sends_definitions: bool = True
    # A subscriber of any type is listed before the topic has a publisher.
    lists_untyped_subscribers: bool = True
    # Nodes of one process may use different types on one topic; they do not exchange messages.
    allows_different_types: bool = True
    # If the parameter use_sim_time is true, the time is that of /clock.
    simulates_time: bool = True
    # A node with a client of a service is listed.
    lists_clients: bool = False
    # How the graph writes the type std_msgs/String, and the name of a node's logger.
    string_type: str = "std_msgs/String"
    logger_of_node: str = "/node"
    # The type that the graph reports for a service of type std_srvs/SetBool.
    service_type: str = "*"

    def require(self, capability: str) -> None:
        """Skip the test if the implementation does not have a capability."""
        if not getattr(self, capability):
            pytest.skip(f"this graph lacks: {capability.replace('_', ' ')}")


ROS1 = Capabilities()

MEMORY = replace(ROS1, simulates_time=False, service_type="std_srvs/SetBool")

ROS2 = Capabilities(
    global_parameters=False,
    mixed_lists=False,
    same_name_replaces=False,
    last_server_wins=False,
    detects_slow_subscribers=False,
    sends_definitions=False,
    lists_untyped_subscribers=False,
    lists_clients=True,
    string_type="std_msgs/msg/String",
    logger_of_node="node",
    service_type="std_srvs/srv/SetBool",
)
