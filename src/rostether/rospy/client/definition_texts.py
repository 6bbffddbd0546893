"""The functions of rosmsg for programs: the names and texts of definitions.

Their arguments `raw` and `rospack` have no effect.
"""

from __future__ import annotations

from rostether.errors import DefinitionError
from rostether.rospy.client.message_types import all_types


class ROSMsgException(Exception):
    """The type is unknown, or its definition is invalid."""


def list_msgs(package: str, rospack: object = None) -> list[str]:
    """Return the messages of a package, each as `package/Name`."""
    return all_types().registry.messages(package)


def list_srvs(package: str, rospack: object = None) -> list[str]:
    """Return the services of a package, each as `package/Name`."""
    return all_types().registry.services(package)


def get_msg_text(type_: str, raw: bool = False, rospack: object = None) -> str:
    """Return the text of a message's definition. Raises ROSMsgException."""
    try:
        return all_types().registry.message(type_).text
    except DefinitionError as error:
        raise ROSMsgException(f"{error}") from None


def get_srv_text(type_: str, raw: bool = False, rospack: object = None) -> str:
    """Return the text of a service's definition. Raises ROSMsgException."""
    try:
        service = all_types().registry.service(type_)
    except DefinitionError as error:
        raise ROSMsgException(f"{error}") from None
    return f"{service.request.text}\n---\n{service.response.text}"
