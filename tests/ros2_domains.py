"""A ROS 2 domain on loopback for each test process, so that parallel tests do not discover each other."""

from __future__ import annotations

import fcntl
import functools
import os
import tempfile
from pathlib import Path
from typing import IO

# Domains whose ports Linux does not use for outgoing connections.
_DOMAINS = range(1, 100)

_held: list[IO[bytes]] = []


@functools.cache
def own_domain() -> int:
    """Return a domain that no other test process uses until this one ends.

    It is set in the environment of this process and its children, with discovery on loopback only.
    """
    for domain in _DOMAINS:
        lock = (Path(tempfile.gettempdir()) / f"rostether-test-domain-{domain}").open("wb")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
            continue
        _held.append(lock)
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        return domain
    raise RuntimeError("every ROS 2 domain is in use by other tests")
