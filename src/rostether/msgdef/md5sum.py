"""The md5sum by which two ends of a ROS 1 connection know that they mean the same type.

It is over the constants as written, in order, then the fields with each message type replaced by its own
md5sum (without array brackets); comments, blanks and package names do not count.
"""

from __future__ import annotations

import hashlib

from rostether.msgdef.primitives import PRIMITIVE_TYPES
from rostether.msgdef.resolve_types import Lookup, dependencies
from rostether.msgdef.spec import MessageSpec, ServiceSpec


def message_md5sum(spec: MessageSpec, lookup: Lookup) -> str:
    """Return the md5sum in 32 hexadecimal digits. Raises what `dependencies` raises."""
    return _digest(message_md5_text(spec, lookup))


def service_md5sum(spec: ServiceSpec, lookup: Lookup) -> str:
    """Return the md5sum of a whole service: over the text of the request, then that of the response."""
    return _digest(message_md5_text(spec.request, lookup) + message_md5_text(spec.response, lookup))


def message_md5_text(spec: MessageSpec, lookup: Lookup) -> str:
    """Return the text that is hashed. Raises what `dependencies` raises."""
    nested = {dependency.full_name: dependency for dependency in dependencies(spec, lookup)}
    return _text(spec, nested, {})


def _text(spec: MessageSpec, nested: dict[str, MessageSpec], sums: dict[str, str]) -> str:
    lines = [f"{constant.type} {constant.name}={constant.text}" for constant in spec.constants]
    for field in spec.fields:
        base = field.type.base
        if base in PRIMITIVE_TYPES:
            lines.append(f"{field.type} {field.name}")
            continue
        if base not in sums:
            sums[base] = _digest(_text(nested[base], nested, sums))
        lines.append(f"{sums[base]} {field.name}")
    return "\n".join(lines)


def _digest(text: str) -> str:
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()
