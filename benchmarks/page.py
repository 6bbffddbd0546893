"""The dashboard under load: `python -m benchmarks.page MINUTES` prints processor time and the page's memory.

The dashboard's process is measured without a page, with one, with four, and with one that is hidden. Then one
page stays open for MINUTES; its heap is printed each minute and must not grow.
"""

from __future__ import annotations

import asyncio
import os
import sys
import time
import urllib.request
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from benchmarks.processes import Bench, cpu_s, first_line, resident_mb, wait_until
from interop.ros1_peers import free_port
from web.browser import Browser, page_packages

SECONDS = 8.0
SETTLE_S = 4.0
# A plot keeps five minutes of data, so the page's memory grows during this time.
FILLED_MINUTES = 6
MAX_GROWTH = 0.10


async def main(minutes: float) -> int:
    """Measure; return the exit code, 1 if the heap has grown."""
    with Bench() as bench:
        os.environ["ROS_MASTER_URI"] = bench.master_uri
        first_line(bench.module("page_source"))
        port = free_port()
        url = f"http://127.0.0.1:{port}/"
        dashboard = bench.rostether("dashboard", "--port", str(port), "--no-open")
        wait_until(lambda: _answers(url), "the dashboard")
        browser = await Browser.start(page_packages())
        try:
            print(f"no page      {await _cpu_percent(dashboard.pid):5.1f} % of a core", flush=True)
            page = await browser.do("open", url=url)
            cpu = await _cpu_percent(dashboard.pid)
            print(f"one page     {cpu:5.1f} %, {await _received(browser, [page])}", flush=True)
            await browser.do("hide", page=page, hidden=True)
            print(f"one, hidden  {await _cpu_percent(dashboard.pid):5.1f} %", flush=True)
            await browser.do("hide", page=page, hidden=False)
            others = [await browser.do("open", url=url) for _ in range(3)]
            cpu = await _cpu_percent(dashboard.pid)
            print(f"four pages   {cpu:5.1f} %, {await _received(browser, [page, *others])}", flush=True)
            for each in others:
                await browser.do("close", page=each)
            print(f"memory       {resident_mb(dashboard.pid):5.1f} MB", flush=True)
            return await _watch_heap(browser, page, minutes)
        finally:
            await browser.close()


async def _watch_heap(browser: Browser, page: int, minutes: float) -> int:
    filled = 0.0
    heap = 0.0
    began_s = time.monotonic()
    for minute in range(int(minutes) + 1):
        await asyncio.sleep(max(0.0, began_s + 60 * minute - time.monotonic()))
        heap = (await browser.do("memory", page=page))["bytes"] / 1e6
        count = await browser.do("evaluate", page=page, script="rostether.subscriptionCount")
        print(f"{minute:3d} min  heap {heap:6.1f} MB, {count} subscriptions", flush=True)
        if minute == FILLED_MINUTES:
            filled = heap
    if filled and heap > filled * (1 + MAX_GROWTH):
        print(
            f"the heap grew by {100 * (heap / filled - 1):.0f} % since minute {FILLED_MINUTES}",
            file=sys.stderr,
        )
        return 1
    return 0


async def _received(browser: Browser, pages: list[int]) -> str:
    """Return how much the pages receive; on a busy machine they read less than is sent."""
    script = (
        "[...rostether.topics.value.keys()].map((each) => rostether.feed(each).rate.hertz(performance.now()))"
    )
    rates = [sum(await browser.do("evaluate", page=page, script=script)) for page in pages]
    return " + ".join(f"{rate:.0f}" for rate in rates) + " messages/s received"


async def _cpu_percent(pid: int) -> float:
    await asyncio.sleep(SETTLE_S)
    before_s, began_s = cpu_s(pid), time.monotonic()
    await asyncio.sleep(SECONDS)
    return 100 * (cpu_s(pid) - before_s) / (time.monotonic() - began_s)


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=5) as answer:
            return bool(answer.status == 200)
    except OSError:
        return False


if __name__ == "__main__":
    sys.exit(asyncio.run(main(float(sys.argv[1]))))
