"""<machine>: this machine under another name; nodes are not started on others."""

from __future__ import annotations

import getpass
import re
import socket

from rostether.errors import LaunchError
from rostether.launch.scope import Scope
from rostether.launch.tag_reader import TagReader
from rostether.mechanisms.xml_tree import XmlElement

_ATTRIBUTES = ("name", "address", "env-loader", "ssh-port", "user", "password", "default", "timeout")


def read_machine(reader: TagReader, element: XmlElement, scope: Scope) -> str:
    """Return the name of a machine that is this one. Raises LaunchError for any other."""
    reader.check_attributes(element, _ATTRIBUTES)
    name, address = (reader.required(element, scope, each) for each in ("name", "address"))
    user = reader.optional(element, scope, "user")
    if not _is_here(address) or (user and user != getpass.getuser()):
        raise LaunchError(
            f"machine {name!r} at {address} is another machine, but nodes are started on this one only; "
            "remove <machine>, and run `rostether launch` there with the ROS_MASTER_URI of this machine"
        )
    return name


def _is_here(address: str) -> bool:
    return address in ("localhost", "::1", socket.gethostname()) or bool(
        re.fullmatch(r"127(\.\d{1,3}){3}", address)
    )
