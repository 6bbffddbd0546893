from __future__ import annotations

from programs import started


async def test_options_of_roscore_are_accepted() -> None:
    words = [
        "-v",
        "-w",
        "3",
        "-t",
        "5",
        "--master-logger-level=debug",
        "--sigint-timeout",
        "1",
        "--sigterm-timeout=1",
    ]
    async with started("core", "-p", "0", *words) as core:
        await core.wait_for("ROS_MASTER_URI=")
