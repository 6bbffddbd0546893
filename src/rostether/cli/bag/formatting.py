"""Formats sizes, times and durations of recordings as rosbag prints them."""

from __future__ import annotations

from datetime import datetime

from rostether.rostime import NS_PER_S

# The size of 1 MB in all options and sizes of recordings, as in rosbag.
MEGABYTE = 1024 * 1024


def size_text(size_bytes: float) -> str:
    """Return a size such as `24.4 MB`."""
    for unit in ("B", "KB", "MB", "GB"):
        if size_bytes < 1024:
            return f"{size_bytes:.0f} B" if unit == "B" else f"{size_bytes:.1f} {unit}"
        size_bytes /= 1024
    return f"{size_bytes:.1f} TB"


def time_text(time_ns: int) -> str:
    """Return a time such as `Nov 14 2023 22:13:20.00 (1700000000.00)`, in local time, like rosbag."""
    seconds = time_ns / NS_PER_S
    rounded_ns = (time_ns + 5_000_000) // 10_000_000 * 10_000_000
    try:
        local = datetime.fromtimestamp(rounded_ns // NS_PER_S).astimezone()
    except (OverflowError, OSError, ValueError):
        return f"{seconds:.2f}"
    hundredths = rounded_ns % NS_PER_S // 10_000_000
    return f"{local:%b %d %Y %H:%M:%S}.{hundredths:02d} ({seconds:.2f})"


def duration_text(seconds: float) -> str:
    """Return a duration such as `3.0s`, `1:05s (65s)` or `1hr 02:03s (3723s)`."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours}hr {minutes:02d}:{rest:02d}s ({int(seconds)}s)"
    return f"{minutes}:{rest:02d}s ({int(seconds)}s)" if minutes else f"{seconds:.1f}s"
