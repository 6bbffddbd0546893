"""Where a zenoh session connects and listens, and whether it is the router of this machine.

The command line reads these as options, so they need no library: the help of a command starts faster.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class RouterChoice(Enum):
    """When a zenoh session becomes the router of this machine."""

    # Becomes the router if no router answers.
    AUTO = "auto"
    # Waits for a router without a time limit.
    NEVER = "never"
    # Fails if the address is in use. Configured listen endpoints replace the default one.
    ALWAYS = "always"


class ZenohReach(NamedTuple):
    """Where a zenoh session connects and listens, besides the usual endpoints: `tcp/192.168.1.7:7447`."""

    router: RouterChoice = RouterChoice.AUTO
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()
