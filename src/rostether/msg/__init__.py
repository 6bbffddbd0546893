"""The bundled messages as classes: `from rostether.msg.std_msgs import String`.

Type checkers know their fields, which are those of ROS 1. Received messages of the same definition are
instances of these classes. A workspace's own messages have no classes here: name them by type
(`"my_msgs/Speed"`).
"""

from __future__ import annotations

from rostether.serde.class_modules import add_class_modules, bundled_store
from rostether.serde.values import Message


def _find(name: str) -> type[Message]:
    return bundled_store().codec(name).message_class


add_class_modules(globals(), _find, "message")
