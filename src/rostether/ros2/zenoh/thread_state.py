"""Keeps Python's state of a thread that zenoh created."""

from __future__ import annotations

import ctypes
import threading

_kept = threading.local()


def keep_thread_state() -> None:
    """Keep the calling thread's state; call it at the start of a callback that zenoh calls often.

    Without this, Python creates and destroys a state for each call.
    """
    # Thread-local data ends with the state, so a new state has none.
    if not hasattr(_kept, "is_kept"):
        _kept.is_kept = True
        ctypes.pythonapi.PyGILState_Ensure()
