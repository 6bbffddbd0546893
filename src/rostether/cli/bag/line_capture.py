"""The recording of the bytes on a bridge's lines: its size limit, and the capture file."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.bag.formatting import MEGABYTE, size_text
from rostether.cli.shell.option_group import NumberRange, add_option
from rostether.graph.ports import Level

if TYPE_CHECKING:
    from rostether.bridge.reporter import Reporter
    from rostether.transports.transport import Transport


record_limit_option = add_option(
    "--record-limit record_limit_mb MB",
    "Stop recording, but keep serving, when the file reaches this size (default: 100).",
    type=NumberRange(min=0.01),
    default=100,
)


@asynccontextmanager
async def recorded(
    path: Path | None, limit_mb: float, reporter: Reporter
) -> AsyncIterator[Callable[[Transport], Transport] | None]:
    """Yield a function that records a transport into a new file, None without a path. Raises ConfigError."""
    if path is None:
        yield None
        return
    from datetime import UTC, datetime
    from importlib.metadata import version

    from rostether.transports.capture_writer import CaptureWriter

    writer = CaptureWriter(
        path,
        clock=asyncio.get_running_loop().time,
        description={
            "started": datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z"),
            "host": f"rostether {version('rostether')}",
        },
        limit_bytes=int(limit_mb * MEGABYTE),
        report=lambda text: reporter.report(Level.WARN, text),
    )
    reporter.report(Level.INFO, f"Recording the lines to {path}")
    try:
        yield writer.tap
    finally:
        writer.close()
        reporter.report(Level.INFO, f"{path} holds {size_text(writer.written_bytes)}")
