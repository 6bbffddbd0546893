from __future__ import annotations

import fcntl
import os
from pathlib import Path

from rostether.ros2.rclpy.left_over_memory import find_leftover_files


def test_memory_without_a_lock_is_left_over(tmp_path: Path) -> None:
    files = ["fastdds_1f3f4bb2bebb5044", "fastrtps_port7411", "fastdds_a3f92bab2af4595e", "fastdds_port7413"]
    for name in files:
        (tmp_path / name).touch()
        (tmp_path / f"{name}_el").touch()
        os.utime(tmp_path / f"{name}_el", (1000, 1000))
    (tmp_path / "fastdds_0000000000000000_el").touch()  # of a program that starts now
    (tmp_path / "other_el").touch()
    with (tmp_path / f"{files[2]}_el").open() as held, (tmp_path / f"{files[3]}_el").open() as shared:
        fcntl.flock(held, fcntl.LOCK_EX)
        fcntl.flock(shared, fcntl.LOCK_SH)
        assert find_leftover_files(tmp_path) == files[:2]
    assert len(find_leftover_files(tmp_path)) == 4
    assert find_leftover_files(tmp_path / "missing") == []
