"""Chromium with the dashboard's page, controlled through `browser.mjs`."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import os
import shutil
import signal
from pathlib import Path
from typing import Any

import children
from interop_web.web_peers import install_packages, node_folder

ROOT = Path(__file__).parents[2]
WEB = ROOT / "web"
PROGRAM = Path(__file__).parent / "browser.mjs"
# Chromium without its user interface starts and opens pages in a fifth of the processor time.
HEADLESS = "chromium-headless-shell"
# The complete Chromium. The headless shell has no camera.
CHROMIUM = "chromium"
TIMEOUT_S = 60.0
POLL_S = 0.1


def page_packages() -> Path:
    """Return a folder whose node_modules has playwright-core; raises CalledProcessError, TimeoutExpired."""
    return WEB if (WEB / "node_modules/playwright-core").exists() else install_packages(WEB).parent


class Browser:
    """One Chromium; pages are numbers."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process
        self._numbers = itertools.count(1)

    @classmethod
    async def start(cls, packages: Path, program: str = HEADLESS) -> Browser:
        """Start it; the complete Chromium if `program` is not installed."""
        node, chromium = node_folder(), shutil.which(program) or shutil.which(CHROMIUM)
        assert node is not None
        assert chromium is not None
        process = await asyncio.create_subprocess_exec(
            str(node / "node"),
            str(PROGRAM),
            str(packages),
            chromium,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            limit=1 << 24,
            env=children.environment_of_session(),
            start_new_session=True,
        )
        return cls(process)

    async def close(self) -> None:
        """End it; at the end of its input, the program closes Chromium and waits for its end."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            await asyncio.wait_for(self._process.wait(), TIMEOUT_S)
        except TimeoutError:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
            await self._process.wait()

    async def do(self, command: str, **arguments: Any) -> Any:
        """Run a command of `browser.mjs`."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        number = next(self._numbers)
        self._process.stdin.write(
            json.dumps({"id": number, "command": command, **arguments}).encode() + b"\n"
        )
        answer: dict[str, Any] = {}
        # The answer to a canceled command still arrives.
        while answer.get("id") != number:
            line = await asyncio.wait_for(self._process.stdout.readline(), TIMEOUT_S)
            assert line, "the browser's program has ended"
            answer = json.loads(line)
        if "error" in answer:
            raise AssertionError(f"{command} {arguments}: {answer['error']}")
        return answer["result"]

    async def wait_for(self, page: int, script: str) -> None:
        """Wait until a script's value is true."""
        try:
            async with asyncio.timeout(TIMEOUT_S):
                # A page sends no events; a check is fast.
                while not await self.do("evaluate", page=page, script=script):
                    await asyncio.sleep(POLL_S)
        except TimeoutError:
            text = await self.do("evaluate", page=page, script="document.body.innerText")
            raise AssertionError(f"never true: {script}; the page shows: {text[:2000]}") from None
