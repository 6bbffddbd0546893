"""Converts the names of C++ symbols to readable ones."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable

from rostether.mechanisms.program import run_program

_PROGRAMS = ("avr-c++filt", "c++filt")
_CLONE = re.compile(r"(\.(?:constprop|isra|part|lto_priv|cold)(?:\.\d+)*)+$")
_ABBREVIATIONS = (("unsigned char", "uint8_t"), ("unsigned int", "uint16_t"), ("unsigned long", "uint32_t"))


async def demangle(names: Iterable[str]) -> dict[str, str]:
    """Return readable names for linker names; without c++filt, the names stay unchanged."""
    wanted = sorted(set(names))
    program = next((found for each in _PROGRAMS if (found := shutil.which(each))), None)
    # c++filt does not convert variables whose names end in a clone's number.
    readable = originals = [_CLONE.sub("", name) for name in wanted]
    if program is not None and wanted:
        ended = await run_program([program], input_data="\n".join(originals).encode(), merge=False)
        lines = ended.output.decode("utf-8", "replace").splitlines()
        readable = lines if len(lines) == len(wanted) else originals
    return dict(zip(wanted, readable, strict=True))


def shorten(name: str) -> str:
    """Return a name without parameter types, return type and unnamed namespaces."""
    name = name.replace("(anonymous namespace)::", "")
    depth = begin = 0
    for index, character in enumerate(name):
        depth += (character == "<") - (character == ">")
        if character == " " and depth == 0:
            begin = index + 1
        if character == "(" and depth == 0 and index and not name.endswith("operator"):
            # Only the name of a template begins with its return type.
            name = name[begin if name[index - 1] == ">" else 0 : index] + "()"
            break
    for long, short in _ABBREVIATIONS:
        name = name.replace(long, short)
    return name
