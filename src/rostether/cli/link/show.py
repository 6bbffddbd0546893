"""`rostether link show`: the frames of a capture, one per line."""

from __future__ import annotations

import contextlib
from collections import Counter
from pathlib import Path

import click

from rostether.bridge.reporter import shown_line
from rostether.cli.shell.option_group import PATH, add_flag
from rostether.cli.shell.output import json_option, write_line, write_result
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.text import counted
from rostether.rosserial.line_log import LineEntry, LineLog, version_of
from rostether.transports.capture import Capture, Chunk, LinkClosed, LinkOpened

# Enough to recognize text and the beginning of a frame.
_SHOWN_BYTES = 16
# The first frames of a line show its version; more frames change nothing.
_VERSION_SEARCH_BYTES = 64 * 1024


@verb(
    "show",
    """
    rostether link show problem.jsonl
    rostether link show problem.jsonl --faults
    rostether link show problem.jsonl --json | head
    """,
)
@click.argument("file", type=PATH)
@add_flag("--faults", "List only bytes that are not part of a valid frame.")
@json_option
def link_show(file: Path, faults: bool, as_json: bool) -> None:
    """List the frames of a capture: time, direction, topic id, length of the payload and description.

    Bytes that are not part of a valid frame are marked with `!`. The last line shows the totals.
    """
    capture = Capture(file)
    version = capture.version or _version(capture)
    logs: dict[int, LineLog] = {}
    counts: Counter[str] = Counter()

    def show(link: int, entries: list[LineEntry]) -> None:
        for entry in entries:
            side = "device" if entry.from_device else "host"
            counts[f"{side} {'faults' if entry.fault else 'frames'}"] += 1
            if faults and not entry.fault:
                continue
            write_result(_record(link, entry), _line(link, entry), as_json=as_json)

    time_s = 0.0
    for each in capture.entries():
        time_s = each.time_s
        match each:
            case Chunk():
                log = logs.setdefault(each.link, LineLog(version))
                show(each.link, list(log.feed(each.time_s, each.from_device, each.data)))
            case LinkOpened() | LinkClosed():
                ended = logs.pop(each.link, None)
                show(each.link, list(ended.finish(time_s)) if ended is not None else [])
                if not as_json:
                    what = f"opened: {shown_line(each.peer)}" if isinstance(each, LinkOpened) else "closed"
                    write_line(f"{time_s:12.6f}  link {each.link} {what}")
    for link, log in logs.items():
        show(link, list(log.finish(time_s)))
    if not as_json:
        write_line(
            f"protocol version {version}, {time_s:.1f} s; "
            f"from the board {counted(counts['device frames'], 'frame')}, "
            f"{counted(counts['device faults'], 'fault')}; "
            f"from the host {counted(counts['host frames'], 'frame')}, "
            f"{counted(counts['host faults'], 'fault')}"
        )


def _version(capture: Capture) -> int:
    seen = bytearray()
    # A bad line is reported when the listing reaches it.
    with contextlib.suppress(ConfigError):
        for each in capture.entries():
            if isinstance(each, Chunk) and each.from_device:
                seen += each.data
            if len(seen) >= _VERSION_SEARCH_BYTES:
                break
    return version_of(bytes(seen))


def _line(link: int, entry: LineEntry) -> str:
    of_link = f" link {link}" if link > 1 else ""
    side = "board ->" if entry.from_device else "<- host "
    if entry.fault:
        shown = entry.data[:_SHOWN_BYTES]
        text = "".join(chr(byte) if 32 <= byte < 127 else "." for byte in shown)
        more = "..." if len(entry.data) > len(shown) else ""
        what = f"! {entry.fault}: {shown.hex()}{more}  {text}{more}"
    else:
        what = entry.what
    topic_id = "" if entry.topic_id is None else str(entry.topic_id)
    return f"{entry.time_s:12.6f}{of_link}  {side} {topic_id:>5} {len(entry.data):>6} B  {what}"


def _record(link: int, entry: LineEntry) -> dict[str, object]:
    return {
        "t": entry.time_s,
        "link": link,
        "from": "device" if entry.from_device else "host",
        "topic_id": entry.topic_id,
        "what": entry.what,
        "fault": entry.fault or None,
        "hex": entry.data.hex(),
    }
