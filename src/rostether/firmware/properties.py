"""Arduino's `key=value` files: boards.txt, platform.txt and library.properties.

Source: the Arduino platform specification and library specification.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping

# Real recipes are nested three levels deep; keys that refer to each other in a cycle must not loop forever.
MAX_EXPANSIONS = 64

_PLACEHOLDER = re.compile(r"\{([\w.\-]+)\}")


def parse_properties(text: str) -> dict[str, str]:
    """Return the keys with their values; comments, empty lines and lines without `=` are skipped."""
    properties = {}
    for line in text.splitlines():
        key, equals, value = line.strip().partition("=")
        if equals and not key.startswith("#"):
            properties[key.strip()] = value.strip()
    return properties


def expand(template: str, properties: Mapping[str, str]) -> str:
    """Return a value with every `{key}` replaced recursively; unknown keys stay."""
    for _ in range(MAX_EXPANSIONS):
        expanded = _PLACEHOLDER.sub(lambda match: properties.get(match[1], match[0]), template)
        if expanded == template:
            break
        template = expanded
    return template


def command_line(recipe: str, properties: Mapping[str, str]) -> list[str]:
    """Return the arguments of a recipe; an unknown key such as `{includes}` stays one argument."""
    return shlex.split(expand(recipe, properties))
