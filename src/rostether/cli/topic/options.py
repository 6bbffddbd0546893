"""The options of `rostether topic`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import click

from rostether.cli.access.completions import complete_topics
from rostether.cli.access.options import msg_path_option, refuse_ros2_only
from rostether.cli.shell.option_group import COUNT, PATH, POSITIVE, add_flag, argument, flag, option, shared
from rostether.cli.shell.output import json_option

hidden_topics_option = add_flag(
    "--include-hidden-topics with_hidden", "With --ros2, include hidden topics (_name)."
)


@dataclass(frozen=True, slots=True)
class TopicListing:
    """The options of `topic list`."""

    namespace: str | None = argument(required=False, shell_complete=complete_topics)
    bag: Path | None = option("-b --bag FILE", "List the topics of this recording.", type=PATH)
    verbose: bool = flag("-v --verbose", "Show types and how many nodes publish and subscribe.")
    publishers: bool = flag("-p", "List only topics that are published.")
    subscribers: bool = flag("-s", "List only topics that are subscribed to.")
    by_host: bool = flag("--host", "Group by machine.")
    show_types: bool = flag("-t --show-types", "Show types.")
    count_topics: bool = flag("-c --count-topics", "Print only the number of topics.")
    with_hidden: bool = shared(hidden_topics_option, False)
    as_json: bool = shared(json_option, False)


@dataclass(frozen=True, slots=True)
class EchoOptions:
    """The options of `topic echo`; `expression` selects the messages to print."""

    bag: Path | None = option("-b --bag FILE", "Print the messages of this recording.", type=PATH)
    all_topics: bool = flag("-a --all", "With -b, print the messages of all topics.")
    count: int | None = option("-n --count COUNT", "Stop after COUNT messages.", type=COUNT)
    once: bool = flag("--once", "Stop after one message.")
    plot: bool = flag("-p", "Print comma-separated values, for plotting.")
    as_json: bool = shared(json_option, False)
    clear: bool = flag("-c --clear", "Clear the screen before each message.")
    noarr: bool = flag("--noarr --no-arr", "Omit arrays.")
    nostr: bool = flag("--nostr --no-str", "Omit strings.")
    number_width: int | None = option(
        "-w WIDTH", "Print numbers with this width, in columns.", type=click.IntRange(min=2)
    )
    offset: bool = flag("--offset", "Print times relative to now, in seconds.")
    expression: str | None = option(
        "--filter EXPRESSION", "Print only messages m for which the Python expression is true."
    )
    field: str = option("--field FIELD", "Print only this field, e.g. header.stamp.", default="")
    csv: bool = flag("--csv", "With --ros2, print comma-separated values.")
    full_length: bool = flag("-f --full-length", "With --ros2, do not truncate arrays and strings.")
    truncate_length: int | None = option(
        "-l --truncate-length LENGTH",
        "With --ros2, truncate arrays and strings to LENGTH (default: 128).",
        type=click.IntRange(min=0),
    )
    flow_style: bool = flag("--flow-style", "With --ros2, print each message on one line.")
    timeout_s: float | None = option("--timeout SECONDS", "With --ros2, stop after SECONDS.", type=POSITIVE)
    msg_paths: tuple[Path, ...] = shared(msg_path_option, ())

    @property
    def wanted_count(self) -> int | None:
        """The number of messages to print, None without a limit."""
        return 1 if self.once else self.count

    def refuse_ros2_only(self) -> None:
        """Raise UsageError if an option of ROS 2 was given."""
        refuse_ros2_only(
            csv=self.csv,
            full_length=self.full_length,
            truncate_length=self.truncate_length is not None,
            flow_style=self.flow_style,
            timeout_s=self.timeout_s,
        )

    def compiled_filter(self) -> Callable[[object, str], bool] | None:
        """Return the filter, None to show all messages. Raises ConfigError for a wrong expression."""
        if self.expression is None:
            return None
        from rostether.expression.compiler import compile_filter

        return compile_filter(self.expression)


def with_field(topic: str, options: EchoOptions) -> str:
    """Return `TOPIC/FIELD`, the form of rostopic for ROS 2's `--field`."""
    return f"{topic}/{options.field.replace('.', '/')}" if options.field else topic


@dataclass(frozen=True, slots=True)
class PubOptions:
    """The options of `topic pub`."""

    once: bool = flag(
        "-1 --once", "Publish one message and exit after 3 s; with --ros2, as soon as subscribers have it."
    )
    rate_hz: float | None = option(
        "-r --rate HZ", "Publish repeatedly, this many times a second.", type=POSITIVE
    )
    latch: bool = flag("-l --latch", "Also latch with -r, -f and pipes; a single message is always latched.")
    file: Path | None = option("-f --file", "Read the messages from a YAML file.", type=PATH)
    substitute_keywords: bool = flag(
        "-s --substitute-keywords", "With -r, fill in `now` and `auto` for each message."
    )
    use_rostime: bool = flag("--use-rostime", "Stamp with ROS time, not with this machine's clock.")
    verbose: bool = flag("-v", "Show what is published.")
    times: int = option(
        "-t --times --count COUNT",
        "With --ros2, stop after COUNT messages.",
        type=click.IntRange(min=0),
        default=0,
    )
    wait_for: int | None = option(
        "-w --wait-matching-subscriptions COUNT",
        "With --ros2, wait for COUNT subscribers (default: 1 with -1 and -t, otherwise 0).",
        type=click.IntRange(min=0),
    )
    max_wait_s: float | None = option(
        "--max-wait-time-secs SECONDS",
        "With --ros2, stop waiting for subscribers after SECONDS.",
        type=POSITIVE,
    )
    print_nth: int | None = option(
        "-p --print N", "With --ros2, show only every N-th message.", type=click.IntRange(min=0)
    )
    qos_durability: str | None = option(
        "--qos-durability DURABILITY",
        "With --ros2, transient_local is the same as -l.",
        type=click.Choice(["volatile", "transient_local", "system_default"]),
    )
    msg_paths: tuple[Path, ...] = shared(msg_path_option, ())
