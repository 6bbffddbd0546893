"""`rostether bag info`: shows the contents of recordings."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import yaml

from rostether.bounded_yaml import YamlError, load
from rostether.cli.bag.formatting import duration_text, size_text, time_text
from rostether.cli.shell.option_group import PATH, add_flag, add_option
from rostether.cli.shell.output import json_option, paint_keys, warn, write_json, write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.text import escape_line
from rostether.rostime import NS_PER_S, Time

if TYPE_CHECKING:
    from rostether.recording.recorded import RecordingReader

# A step in the value of --key: `.name` or `[0]`.
_STEP = re.compile(r"\.?(?:(\w+)|\[(-?\d+)\])")


@verb(
    "info",
    """
    rostether bag info drive.bag
    rostether bag info --freq drive.bag
    rostether bag info -y -k duration drive.bag
    rostether bag info --json *.bag
    """,
)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=PATH)
@add_flag("-y --yaml as_yaml", "Print YAML.")
@add_option("-k --key KEY", "With --yaml: print only the value of KEY.")
@add_flag("--freq with_rates", "Show the message rate of each topic.")
@json_option
def bag_info(
    files: tuple[Path, ...], as_yaml: bool, key: str | None, with_rates: bool, as_json: bool
) -> None:
    """Show the duration, the number of messages, the topics and the types of recordings."""
    from rostether.recording.files import open_recording
    from rostether.recording.message_rates import message_rates_hz

    if key is not None and not as_yaml:
        raise click.UsageError("-k needs -y")
    for number, path in enumerate(files):
        with closing(open_recording(path)) as reader:
            facts = _facts(path, reader)
            for topic, why in reader.unreadable.items():
                warn(f"{path}: {topic} is not shown: {why}")
            if with_rates:
                rates = message_rates_hz(reader)
                for row in facts["topics"]:
                    if row["topic"] in rates:
                        row["frequency_hz"] = rates[row["topic"]]
            if reader.damage:
                warn(f"{path}: {reader.damage}; `rostether bag reindex {path}` repairs it")
            if number and not as_json:
                write_line("---")
            if as_json:
                write_json(facts)
            elif as_yaml:
                text = yaml_text(facts, reader)
                write_line(text if key is None else yaml_value(text, key))
            else:
                _print(facts, reader)


def _facts(path: Path, reader: RecordingReader) -> dict[str, Any]:
    topics: dict[str, dict[str, Any]] = {}
    for connection, count in reader.counts.items():
        row = topics.setdefault(
            connection.topic,
            {"topic": connection.topic, "type": connection.shown_type, "messages": 0, "connections": 0},
        )
        row["messages"] += count
        row["connections"] += 1
    types = {
        each.shown_type: each.type.md5sum if each.origin is None else each.origin.type_hash
        for each in reader.counts
    }
    facts: dict[str, Any] = {"path": str(path), "version": reader.format_version}
    if (span := reader.span_ns) is not None:
        facts |= {
            "duration_s": (span[1] - span[0]) / NS_PER_S,
            "start_s": span[0] / NS_PER_S,
            "end_s": span[1] / NS_PER_S,
        }
    return facts | {
        "size_bytes": reader.size_bytes,
        "messages": sum(row["messages"] for row in topics.values()),
        "indexed": not reader.damage,
        "compression": reader.compressions[0].name if reader.compressions else "none",
        "types": [{"type": name, "md5": types[name]} for name in sorted(types)],
        "topics": [topics[name] for name in sorted(topics)],
    }


def _print(facts: Mapping[str, Any], reader: RecordingReader) -> None:
    rows = [("path", str(facts["path"])), ("version", str(facts["version"]))]
    if (span := reader.span_ns) is not None:
        rows += [
            ("duration", duration_text(facts["duration_s"])),
            ("start", time_text(span[0])),
            ("end", time_text(span[1])),
        ]
    rows += [("size", size_text(reader.size_bytes)), ("messages", str(facts["messages"]))]
    rows += _compression_rows(reader, facts.get("duration_s", 0.0))
    width = max((len(each["type"]) for each in facts["types"]), default=0)
    rows += _block("types", [f"{each['type']:<{width}} [{each['md5']}]" for each in facts["types"]])
    rows += _block("topics", _topic_lines(facts["topics"]))
    width = max(len(label) for label, _ in rows) + 1
    for label, text in rows:
        write_line(f"{label + ':' if label else '':<{width}} {escape_line(text)}", paint_keys)


def _block(label: str, lines: list[str]) -> list[tuple[str, str]]:
    return [(label if not index else "", line) for index, line in enumerate(lines)]


def _topic_lines(topics: Sequence[Mapping[str, Any]]) -> list[str]:
    name_width = max((len(row["topic"]) for row in topics), default=0)
    count_width = max((len(str(row["messages"])) for row in topics), default=0)
    rates = {row["topic"]: _rate_text(row["frequency_hz"]) for row in topics if "frequency_hz" in row}
    rate_width = max(map(len, rates.values()), default=0)
    lines = []
    for row in topics:
        word = "msg " if row["messages"] == 1 else "msgs"
        rate = rates.get(row["topic"], "")
        line = f"{row['topic']:<{name_width}}   {row['messages']:>{count_width}} {word}"
        line += f" {'@' if rate else ' '} {rate:>{rate_width}} : {row['type']}"
        if row["connections"] > 1:
            line += f" ({row['connections']} connections)"
        lines.append(line)
    return lines


def _compression_rows(reader: RecordingReader, duration_s: float) -> list[tuple[str, str]]:
    shares = reader.compressions
    total = sum(share.chunk_count for share in shares)
    plain = sum(share.size_bytes for share in shares)
    stored = sum(share.compressed_bytes for share in shares)
    parts = []
    for share in shares:
        is_compressed = share.name != "none" and share.size_bytes
        ratio = f"; {share.compressed_bytes / share.size_bytes:.2%}" if is_compressed else ""
        parts.append(f"{share.name} [{share.chunk_count}/{total} chunks{ratio}]")
    rows = [("compression", ", ".join(parts) or "none [0/0 chunks]")]
    if any(share.name != "none" for share in shares) and duration_s and plain:
        speed = f"{size_text(stored)} @ {size_text(stored / duration_s)}/s"
        rows += [
            ("uncompressed", f"{size_text(plain)} @ {size_text(plain / duration_s)}/s"),
            ("compressed", f"{speed} ({stored / plain:.2%})"),
        ]
    return rows


def _rate_text(hz: float) -> str:
    for unit in ("Hz", "kHz", "MHz"):
        if hz < 1000:
            return f"{hz:.1f} {unit}"
        hz /= 1000
    return f"{hz:.1f} GHz"


def yaml_text(facts: Mapping[str, Any], reader: RecordingReader) -> str:
    """Return the facts of a recording as rosbag's YAML; `frequency` only for topics whose rate is known."""
    lines = [f"path: {_word(facts['path'])}", f"version: {facts['version']}"]
    if (span := reader.span_ns) is None:
        return "\n".join([*lines, f"size: {reader.size_bytes}", "indexed: False\n"])
    start_s, end_s = (Time.from_ns(each).to_s() for each in span)
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
    """Return the value of a key of YAML, such as `duration` or `topics[0].messages`. Raises ConfigError."""
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
    """Return a text as YAML, without quotes if possible."""
    with suppress(YamlError):
        if load(f"a: {text}") == {"a": text}:
            return text
    quoted = str(yaml.safe_dump(text, width=1 << 30))
    return quoted.removesuffix("\n").removesuffix("\n...")
