"""The md5sum of a type, which two ends of a ROS 1 connection compare.

Its input is the constants as written, in order, then the fields, with each message type replaced by its own
md5sum (without array brackets); comments, blanks and package names do not count.

Source: genmsg.gentools.compute_md5 of ROS 1.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping

from rostether.msgdef.primitives import PRIMITIVE_TYPES
from rostether.msgdef.resolve_types import Lookup, dependencies
from rostether.msgdef.spec import Constant, Field, MessageSpec, ServiceSpec


def message_md5sum(spec: MessageSpec, lookup: Lookup) -> str:
    """Return the md5sum in 32 hexadecimal digits. Raises the errors of `dependencies`."""
    return digest(message_md5_text(spec, lookup))


def service_md5sum(spec: ServiceSpec, lookup: Lookup) -> str:
    """Return the md5sum of a whole service: that of the request's text followed by the response's.

    Raises the errors of `dependencies`.
    """
    return digest(message_md5_text(spec.request, lookup) + message_md5_text(spec.response, lookup))


def message_md5_text(spec: MessageSpec, lookup: Lookup) -> str:
    """Return the text that is hashed. Raises the errors of `dependencies`."""
    nested = {dependency.full_name: dependency for dependency in dependencies(spec, lookup)}
    return _text(spec, nested, {})


def _text(spec: MessageSpec, nested: dict[str, MessageSpec], sums: dict[str, str]) -> str:
    for field in spec.fields:
        base = field.type.base
        if base not in PRIMITIVE_TYPES and base not in sums:
            sums[base] = digest(_text(nested[base], nested, sums))
    return declarations_text(spec.constants, spec.fields, sums)


def declarations_text(
    constants: Iterable[Constant], fields: Iterable[Field], md5sums: Mapping[str, str]
) -> str:
    """Return the text that is hashed, given the md5sum of every message type among the fields."""
    lines = [f"{constant.type} {constant.name}={constant.text}" for constant in constants]
    lines.extend(f"{md5sums.get(field.type.base, field.type)} {field.name}" for field in fields)
    return "\n".join(lines)


def digest(text: str) -> str:
    """Return the md5sum of a text in 32 hexadecimal digits."""
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()
