"""genpy.dynamic: message classes made from the text of a definition, as bags and connections contain it."""

from __future__ import annotations

from rostether.msgdef.registry import Registry
from rostether.rospy.client.message import Message
from rostether.rospy.client.message_types import MessageTypes


def generate_dynamic(core_type: str, msg_cat: str) -> dict[str, type[Message]]:
    """Return the classes of a type and of those in its full text, by name. Raises DefinitionError."""
    registry = Registry.of_full_text(core_type, msg_cat)
    types = MessageTypes(registry)
    return {name: types.message_class(name) for name in registry.messages()}
