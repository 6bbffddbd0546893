from __future__ import annotations

import errno

from rostether.cli.access.ros1_access import no_master
from rostether.errors import MasterUnreachableError
from rostether.ros1.environment import RosEnvironment


def test_a_master_on_an_unreachable_machine_is_reported_in_the_words_of_the_system() -> None:
    error = MasterUnreachableError("away")
    error.__cause__ = OSError(errno.EHOSTUNREACH, "Connect call failed ('192.0.2.1', 11311)")
    text = str(no_master(RosEnvironment(master_uri="http://192.0.2.1:11311"), error))
    assert text.startswith("no ROS master answers at http://192.0.2.1:11311 (No route to host); start one")
