"""The error line for an unknown ROS 2 type: which package is missing, or which name was meant."""

from __future__ import annotations

import re
from typing import Protocol

from rostether.errors import UnknownTypeError
from rostether.mechanisms.text import did_you_mean
from rostether.msgdef.definition_files import Kind
from rostether.msgdef.registry import MAX_NAME_CHARACTERS

HOW_TO_GIVE = "source the ROS 2 workspace that contains it, or give its folder with --msg-path DIR"

_NAME = re.compile(r"([A-Za-z][A-Za-z0-9_]*)/(msg|srv|action)/([A-Za-z][A-Za-z0-9_]*)")

_EXAMPLES = {
    Kind.MESSAGE: "std_msgs/msg/String",
    Kind.SERVICE: "std_srvs/srv/SetBool",
    Kind.ACTION: "example_interfaces/action/Fibonacci",
}
_NOUNS = {Kind.MESSAGE: "message", Kind.SERVICE: "service", Kind.ACTION: "action"}


class _KnownNames(Protocol):
    """The full names of definitions: of all packages, or of one."""

    def packages(self) -> list[str]: ...
    def names(self, kind: Kind, package: str | None = None) -> list[str]: ...


def split_name(name: str, kind: Kind = Kind.MESSAGE) -> tuple[str, Kind, str]:
    """Split `package/msg/Name`, or the same with `srv` or `action`.

    Raises UnknownTypeError with an example of a `kind`.
    """
    found = _NAME.fullmatch(name) if len(name) <= MAX_NAME_CHARACTERS else None
    if found is None:
        example = _EXAMPLES[kind]
        raise UnknownTypeError(
            f"{name[:80]!r} is not a ROS 2 type name; write package/{kind}/Name, such as {example}"
        )
    return found[1], Kind(found[2]), found[3]


def explain_unknown(known: _KnownNames, kind: Kind, package: str, short_name: str) -> str:
    """Return why `package/kind/short_name` is unknown and what to do."""
    wanted = f"{package}/{kind}/{short_name}"
    packages = known.packages()
    if package not in packages:
        meant = did_you_mean(package, packages, then=" Otherwise, ")
        return f"no ROS 2 package {package!r} is known for {wanted}; {meant}{HOW_TO_GIVE}"
    names, noun = known.names(kind, package), _NOUNS[kind]
    short_names = [each.rpartition("/")[2] for each in names]
    meant = did_you_mean(short_name, short_names, prefix=f"{package}/{kind}/", then=" Otherwise, ")
    return f"the ROS 2 package {package!r} has no {noun} {short_name!r}; {meant}{HOW_TO_GIVE}"


def explain_only_idl(package: str, kind: Kind, short_name: str) -> str:
    """Return an explanation for a type that exists only as IDL."""
    return (
        f"{package}/{kind}/{short_name} is installed as .idl only, which rostether does not read;"
        f" write it as {short_name}.{kind} and give its folder with --msg-path DIR"
    )
