from __future__ import annotations

import re
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
_VARIABLE = re.compile(r'"((?:ROS|ROSCONSOLE|RMW|ROSTETHER|ZENOH|XDG|PLATFORM)_[A-Z0-9_]*[A-Z0-9]|NO_COLOR)"')
# Set for the processes that rostether starts, or read only by functions of rospy's modules.
_NOT_FOR_USERS = {
    "ROSTETHER_CALLED_AS",
    "ROSTETHER_IMPORT_PATH",
    "ROSTETHER_PACKAGE_FOLDERS",
    "ROS_IPV6",
    "ROS_ROOT",
    "ROS_TEST_RESULTS_DIR",
}


def test_the_page_lists_every_variable_that_the_code_reads() -> None:
    page = (REPOSITORY / "docs" / "reference" / "environment.md").read_text()
    modules = (REPOSITORY / "src" / "rostether").rglob("*.py")
    read = {name for module in modules for name in _VARIABLE.findall(module.read_text())}
    assert len(read) > 20
    assert read - set(re.findall(r"`([A-Z0-9_]+)`", page)) == _NOT_FOR_USERS
