"""A few seconds of the soak that `make soak` runs for ten minutes."""

from __future__ import annotations

import asyncio
import re
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

REPOSITORY = Path(__file__).parents[3]
SECONDS = 10


@pytest.mark.timeout(300)
async def test_nothing_is_lost_and_nothing_damaged_is_delivered_on_lines_that_fail_all_the_time() -> None:
    soak = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "benchmarks.soak",
        f"{SECONDS / 60:.3f}",
        cwd=REPOSITORY,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
    )
    try:
        reported = (await asyncio.wait_for(soak.communicate(), 90))[0].decode()
    finally:
        if soak.returncode is None:
            soak.kill()
            await soak.wait()
    seen = re.search(
        r"([\d,]+) messages, (\d+) reconnects: 0 whole ones lost, 0 damaged ones delivered", reported
    )
    assert seen is not None, reported
    assert soak.returncode == 0, reported
    assert int(seen[1].replace(",", "")) > 300
    assert int(seen[2]) >= 2
