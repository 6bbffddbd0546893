"""The page of types in ROS 2 agrees with the tables of conversion."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def test_the_page_is_up_to_date() -> None:
    script = Path(__file__).parents[2] / "scripts" / "write-ros2-types"
    subprocess.run([sys.executable, str(script), "--check"], check=True)
