from __future__ import annotations

from programs import started


async def test_what_scripts_give_to_roscore_is_taken() -> None:
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
