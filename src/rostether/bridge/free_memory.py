"""Giving memory back to the system: the C library keeps what boards that have left had filled."""

from __future__ import annotations


def give_back_memory() -> None:
    """Return unused pages to the system, in some 10 ms for 100 MB; without glibc, do nothing."""
    # Not at import: few processes come to need it.
    import ctypes

    try:
        trim = ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):  # only glibc has it
        return
    trim(0)
