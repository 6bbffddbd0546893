"""How many files and sockets this process may have open: a board takes several, and so does a ROS node."""

from __future__ import annotations

MOST_WANTED = 65_536
"""Some systems permit a billion, and subprocesses then take long to close them."""

BOARD_DESCRIPTORS = 10
"""A board's connection, its node's two servers, the connections with the master and of its topics; where we
are the master, both their ends."""

_OTHER_DESCRIPTORS = 128
"""The master's connections, listeners, files: what must be left when all boards are there."""


def allow_many_descriptors() -> None:
    """Raise the soft limit, commonly 1024, to what the system permits; where there is none, do nothing."""
    try:
        import resource
    except ImportError:
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MOST_WANTED if hard == resource.RLIM_INFINITY else min(hard, MOST_WANTED)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        try:
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
        except (OSError, ValueError):
            # macOS permits less than it says; then the limit stays as it is.
            return


def boards_that_fit(most: int) -> int:
    """Return how many boards the limit has room for, at most `most` and at least one."""
    try:
        import resource
    except ImportError:
        return most
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY:
        return most
    return max(1, min(most, (soft - _OTHER_DESCRIPTORS) // BOARD_DESCRIPTORS))
