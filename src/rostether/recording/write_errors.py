"""Explains why a file of a recording cannot be written."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from rostether.errors import RecordingError
from rostether.mechanisms.text import write_failure


@contextlib.contextmanager
def writing(path: object, error_type: type[Exception] = OSError) -> Iterator[None]:
    """Raise RecordingError with the next step if the block, which writes to `path`, raises `error_type`."""
    try:
        yield
    except error_type as error:
        raise RecordingError(write_failure(path, error)) from None
