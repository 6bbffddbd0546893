from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rostether.msg import sensor_msgs, std_msgs
from rostether.msg.std_msgs import String

WRITER = Path(__file__).parents[3] / "scripts" / "write-message-stubs"


def test_the_stubs_are_those_of_the_definitions() -> None:
    subprocess.run([sys.executable, WRITER, "--check"], check=True)


def test_classes() -> None:
    assert String(data="x").data == "x"
    assert sensor_msgs.NavSatFix().status.status == 0
    with pytest.raises(AttributeError, match="no message 'Strng'"):
        _ = std_msgs.Strng  # type: ignore[attr-defined]
