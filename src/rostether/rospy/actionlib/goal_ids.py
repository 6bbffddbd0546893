"""actionlib.GoalIDGenerator: generates the ids of goals that have none."""

from __future__ import annotations

import itertools
from typing import Any

from rostether.rospy.actionlib.action_types import GoalID
from rostether.rospy.client.names import get_name
from rostether.rospy.client.ros_time import Time

_numbers = itertools.count(1)


class GoalIDGenerator:
    """Generates ids that start with a name (default: the node's name)."""

    def __init__(self, name: str | None = None) -> None:
        self.name = get_name() if name is None else name

    def set_name(self, name: str) -> None:
        """Change the name."""
        self.name = name

    def generate_ID(self) -> Any:
        """Return a unique GoalID."""
        now = Time.now()
        return GoalID(id=f"{self.name}-{next(_numbers)}-{now.secs}.{now.nsecs}", stamp=now)
