"""Unique names for nodes whose name does not matter."""

from __future__ import annotations

import os
import random
import re
import socket
import sys

_NOT_IN_NAMES = re.compile(r"[.:-]")


def anonymous_name(base_name: str) -> str:
    """Return a unique node name, as in ROS: from host, process and a random number."""
    number = random.randint(0, sys.maxsize)  # noqa: S311 - it need not be secret
    return _NOT_IN_NAMES.sub("_", f"{base_name}_{socket.gethostname()}_{os.getpid()}_{number}")
