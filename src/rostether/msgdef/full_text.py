"""The full text of a type, as in connection headers (`message_definition`) and bags.

the message's own text
================================================================================
MSG: std_msgs/Header
that message's text
================= ... one such part for every nested message, in order of first use

Source: genmsg.gentools.compute_full_text of ROS 1.
"""

from __future__ import annotations

from rostether.errors import DefinitionError
from rostether.msgdef.resolve_types import Lookup, dependencies
from rostether.msgdef.spec import MessageSpec

SEPARATOR = "=" * 80
_HEADING = "MSG: "

# Peers send full texts; the longest in Debian's message packages has 20 KB.
MAX_FULL_TEXT_CHARACTERS = 1 << 20

# Full texts in use have at most about 30 parts.
MAX_PARTS = 512


def message_full_text(spec: MessageSpec, lookup: Lookup) -> str:
    """Return the message's text, followed by the texts of all nested messages.

    Raises the same errors as `dependencies`.
    """
    below = (
        f"{SEPARATOR}\n{_HEADING}{nested.full_name}\n{nested.text}" for nested in dependencies(spec, lookup)
    )
    return "\n".join([spec.text, *below])


def split_full_text(name: str, definition: str) -> dict[str, str]:
    """Return the texts in a full text by full type name, that of `name` first. Raises DefinitionError."""
    if len(definition) > MAX_FULL_TEXT_CHARACTERS:
        raise DefinitionError(
            f"the definition has more than {MAX_FULL_TEXT_CHARACTERS} characters", file=name
        )
    texts: dict[str, str] = {}
    part_name, lines = name, list[str]()
    expects_heading = False
    for number, line in enumerate(definition.split("\n"), 1):
        if line.rstrip() == SEPARATOR:
            texts.setdefault(part_name, "\n".join(lines))
            lines, expects_heading = [], True
        elif expects_heading:
            if not line.startswith(_HEADING):
                raise DefinitionError("'MSG: package/Name' must follow the '='s", file=name, line=number)
            part_name, expects_heading = line.removeprefix(_HEADING).strip(), False
        else:
            lines.append(line)
        if len(texts) > MAX_PARTS:
            raise DefinitionError(f"the definition has more than {MAX_PARTS} parts", file=name, line=number)
    texts.setdefault(part_name, "\n".join(lines))
    return texts
