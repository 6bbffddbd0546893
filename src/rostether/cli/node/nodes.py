"""The interface of `rostether node` to a graph."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from rostether.cli.shell.option_group import argument, flag, shared
from rostether.cli.shell.output import json_option


@dataclass(frozen=True, slots=True)
class NodeListing:
    """The options of `node list`."""

    namespace: str = argument(default="")
    uris_only: bool = flag("-u", "List addresses instead of names.")
    with_uris: bool = flag("-a --all", "List addresses and names; with --ros2, also hidden nodes.")
    count_nodes: bool = flag("-c --count-nodes", "Print only the number.")
    as_json: bool = shared(json_option, False)


class Nodes(Protocol):
    """The nodes of one graph. Each method is a whole command and raises RostetherError, UsageError."""

    def list_nodes(self, wanted: NodeListing) -> None:
        """Print the nodes."""

    def info(self, names: tuple[str, ...], *, quiet: bool, with_hidden: bool, as_json: bool) -> None:
        """Print what nodes publish, subscribe to and serve."""
