"""Runs scripts like `rostether run`: in a process that finds our rospy, and no real one."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import AsyncIterator, Mapping
from pathlib import Path

from rostether.rospy.environment import script_environment


@contextlib.asynccontextmanager
async def running_script(
    script: str | Path,
    *arguments: str,
    master_uri: str = "",
    packages: Mapping[str, Path] | None = None,
    environ: Mapping[str, str] | None = None,
) -> AsyncIterator[asyncio.subprocess.Process]:
    """Start a script, given as a file or as text; it ends with the block."""
    words = [str(script)] if isinstance(script, Path) else ["-c", script]
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *words,
        *arguments,
        env=script_environment(
            {
                "PATH": os.environ["PATH"],
                "HOME": os.environ.get("HOME", "/"),
                "PYTHONUNBUFFERED": "1",
                "LANG": "C.UTF-8",
                "ROS_MASTER_URI": master_uri,
                **(environ or {}),
            },
            packages,
        ),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.kill()
        await process.communicate()


async def printed(
    script: str | Path,
    *arguments: str,
    master_uri: str = "",
    packages: Mapping[str, Path] | None = None,
    environ: Mapping[str, str] | None = None,
) -> list[str]:
    """Run a script to its end and return the lines of its standard output."""
    async with running_script(
        script, *arguments, master_uri=master_uri, packages=packages, environ=environ
    ) as process:
        out, err = await asyncio.wait_for(process.communicate(), 60)
        assert process.returncode == 0, err.decode()
        return out.decode().splitlines()


async def line_of(process: asyncio.subprocess.Process, text: str) -> str:
    """Wait for a line of standard output with a text, and return it."""
    assert process.stdout is not None
    async with asyncio.timeout(60):
        while line := (await process.stdout.readline()).decode():
            if text in line:
                return line.rstrip("\n")
    raise AssertionError(f"the script ended without {text!r}")
