"""The limit of open files and sockets of this process: a board needs several, and so does a ROS node."""

from __future__ import annotations

from rostether.mechanisms.text import counted

# Some systems permit a billion, and subprocesses then need a long time to close them.
MAX_DESCRIPTORS = 65_536

# A board's connection, its node's two servers, and the connections to the master and of its topics; both ends
# if the master runs in this process.
BOARD_DESCRIPTORS = 10

# The master's connections, listeners and files, besides those of all boards.
_OTHER_DESCRIPTORS = 128


def allow_many_descriptors() -> None:
    """Raise the soft limit, commonly 1024, to the hard limit; without limits, do nothing."""
    try:
        import resource
    except ImportError:
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MAX_DESCRIPTORS if hard == resource.RLIM_INFINITY else min(hard, MAX_DESCRIPTORS)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        try:
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
        except (OSError, ValueError):
            # macOS permits less than it reports; then the limit does not change.
            return


def boards_that_fit(max_boards: int) -> int:
    """Return how many boards the limit has room for, at most `max_boards` and at least one."""
    limit = _soft_limit()
    if limit is None:
        return max_boards
    return max(1, min(max_boards, (limit - _OTHER_DESCRIPTORS) // BOARD_DESCRIPTORS))


def shortage(boards: int) -> str | None:
    """Return a line about missing open files for this many boards; None if they fit."""
    fitting = boards_that_fit(boards)
    if fitting >= boards:
        return None
    needed = _OTHER_DESCRIPTORS + boards * BOARD_DESCRIPTORS
    return (
        f"{boards} boards need up to {needed} open files, but the system permits {_soft_limit()}, enough for "
        f"about {counted(fitting, 'board')}; raise the limit with `ulimit -n {needed}` as root, or with "
        f"LimitNOFILE={needed} in a systemd unit"
    )


def _soft_limit() -> int | None:
    try:
        import resource
    except ImportError:
        return None
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return None if soft == resource.RLIM_INFINITY else soft
