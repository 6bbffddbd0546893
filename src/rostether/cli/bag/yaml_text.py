"""The exact output of `rosbag info -y`: scripts read it with sed as well as with YAML."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import yaml

from rostether.bounded_yaml import YamlError, load
from rostether.errors import ConfigError

if TYPE_CHECKING:
    from rostether.recording.recorded import RecordingReader

_STEP = re.compile(r"\.?(?:(\w+)|\[(-?\d+)\])")


def yaml_text(facts: Mapping[str, Any], reader: RecordingReader) -> str:
    """Return the facts of a recording; a topic's `frequency_hz` where it is known."""
    lines = [f"path: {_word(facts['path'])}", f"version: {facts['version']}"]
    if (span := reader.span_ns) is None:
        return "\n".join([*lines, f"size: {reader.size_bytes}", "indexed: False\n"])
    start_s, end_s = (secs + nsecs / 1e9 for secs, nsecs in (divmod(each, 1_000_000_000) for each in span))
    lines += [f"duration: {end_s - start_s:.6f}", f"start: {start_s:.6f}", f"end: {end_s:.6f}"]
    lines += [f"size: {reader.size_bytes}", f"messages: {facts['messages']}", f"indexed: {not reader.damage}"]
    lines += [f"compression: {facts['compression']}"]
    if any(share.name != "none" for share in reader.compressions):
        lines += [f"uncompressed: {sum(share.size_bytes for share in reader.compressions)}"]
        lines += [f"compressed: {sum(share.compressed_bytes for share in reader.compressions)}"]
    lines += ["types:"]
    for each in facts["types"]:
        lines += [f"    - type: {each['type']}", f"      md5: {each['md5']}"]
    lines += ["topics:"]
    for row in facts["topics"]:
        lines += [f"    - topic: {_word(row['topic'])}", f"      type: {row['type']}"]
        lines += [f"      messages: {row['messages']}"]
        if row["connections"] > 1:
            lines += [f"      connections: {row['connections']}"]
        if "frequency_hz" in row:
            lines += [f"      frequency: {row['frequency_hz']:.4f}"]
    return "\n".join([*lines, ""])


def yaml_value(text: str, key: str) -> str:
    """Return the value of a key such as `duration` or `topics[0].messages`. Raises ConfigError."""
    value = whole = load(text)
    position = 0
    while position < len(key):
        step = _STEP.match(key, position)
        try:
            if step is None:
                raise KeyError(key)
            value = value[step[1] if step[1] is not None else int(step[2])]
        except (KeyError, IndexError, TypeError):
            raise ConfigError(f"there is no key {key!r}; the keys are {', '.join(whole)}") from None
        position = step.end()
    return _shown(value)


def _shown(value: Any, indent: int = 0) -> str:
    if isinstance(value, list):
        return "".join(f"{'  ' * indent}- {_shown(each, indent + 1)}\n" for each in value)
    if isinstance(value, dict):
        return f"\n{'  ' * indent}".join(f"{name}: {each}" for name, each in value.items())
    return f"{'  ' * indent}{value}"


def _word(text: str) -> str:
    """Return a word in YAML, without quotes if possible."""
    try:
        is_plain = load(f"a: {text}") == {"a": text}
    except YamlError:
        is_plain = False
    return (
        text
        if is_plain
        else str(yaml.safe_dump(text, width=1 << 30)).removesuffix("\n").removesuffix("\n...")
    )
