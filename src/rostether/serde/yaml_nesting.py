"""YAML nested so deeply that libyaml, which recurses in C, would end the process instead of failing."""

from __future__ import annotations

MAX_NESTING = 1000
"""Far deeper than any message or parameter; libyaml crashed between 20,000 and 30,000 levels."""

_HARMLESS_CHARACTERS = 10_000
"""Every level takes a character at least: a text as short as this needs no look."""


def refuse_deep_nesting(text: str) -> None:
    """Raise yaml.YAMLError for a text that nests too deeply, or is not YAML up to there."""
    if len(text) <= _HARMLESS_CHARACTERS:
        return
    import yaml

    depth = 0
    for event in yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            if depth > MAX_NESTING:
                raise yaml.YAMLError(f"nested deeper than {MAX_NESTING} levels")
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
