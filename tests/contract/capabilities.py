"""Where implementations of the graph port truly differ, by name; everything else is the same for all."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What one implementation can do that another cannot; the defaults are ROS 1's."""

    # The parameters of all nodes are one tree; else each belongs to a node, and the rest is one's own.
    global_parameters: bool = True
    # A parameter may be a list of several kinds.
    mixed_lists: bool = True
    # A node that joins with a name in use ends the one that had it; else both stay.
    same_name_replaces: bool = True
    # Who offers a service last has it; else both have it.
    last_server_wins: bool = True
    # A failed call carries the text of its failure; else there is no answer, and the server logs it.
    service_errors_travel: bool = True
    # A publisher feels that a subscriber on another node does not read.
    feels_slow_subscribers: bool = True
    # A publisher's definition and md5sum are its own words; else they are those of the same type here.
    definitions_travel: bool = True
    # A subscriber of any type is listed before anybody publishes.
    lists_untyped_subscribers: bool = True
    # Nodes of one process may use different types on one topic, and do not meet.
    types_may_differ: bool = True
    # /clock is the time where the parameter use_sim_time says so.
    simulates_time: bool = True
    # A node that means to call a service is listed as its client.
    lists_clients: bool = False
    # How the graph itself writes std_msgs/String, a logger's name, and the level of a warning.
    string_type: str = "std_msgs/String"
    logger_of_node: str = "/node"
    # What it tells of the type of a std_srvs/SetBool.
    service_type: str = "*"

    def require(self, capability: str) -> None:
        """Skip a test that is about something this implementation does not have."""
        if not getattr(self, capability):
            pytest.skip(f"this graph has not: {capability.replace('_', ' ')}")


ROS1 = Capabilities()

MEMORY = replace(ROS1, simulates_time=False, service_type="std_srvs/SetBool")

ROS2 = Capabilities(
    global_parameters=False,
    mixed_lists=False,
    same_name_replaces=False,
    last_server_wins=False,
    feels_slow_subscribers=False,
    definitions_travel=False,
    lists_untyped_subscribers=False,
    lists_clients=True,
    string_type="std_msgs/msg/String",
    logger_of_node="node",
    service_type="std_srvs/srv/SetBool",
)
