"""The options of the verbs of `rostether topic`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class TopicListing:
    """The options of `topic list`."""

    namespace: str | None = None
    verbose: bool = False
    publishers: bool = False
    subscribers: bool = False
    by_host: bool = False
    show_types: bool = False
    count_topics: bool = False
    with_hidden: bool = False
    as_json: bool = False


@dataclass(frozen=True, slots=True)
class EchoOptions:
    """The options of `topic echo`; `filter` decides which messages are shown."""

    count: int | None = None
    once: bool = False
    plot: bool = False
    as_json: bool = False
    clear: bool = False
    noarr: bool = False
    nostr: bool = False
    number_width: int | None = None
    offset: bool = False
    expression: str | None = None
    field: str = ""
    csv: bool = False
    full_length: bool = False
    truncate_length: int | None = None
    flow_style: bool = False
    timeout_s: float | None = None
    msg_paths: tuple[Path, ...] = ()

    @property
    def wanted_count(self) -> int | None:
        """How many messages to show, None without a limit."""
        return 1 if self.once else self.count

    def compiled_filter(self) -> Callable[[object, str], bool] | None:
        """Return the filter, None to show all messages. Raises ConfigError for a wrong expression."""
        if self.expression is None:
            return None
        from rostether.expression.compiler import compile_filter

        return compile_filter(self.expression)


@dataclass(frozen=True, slots=True)
class PubOptions:
    """The options of `topic pub`."""

    once: bool = False
    rate_hz: float | None = None
    latch: bool = False
    file: Path | None = None
    substitute_keywords: bool = False
    use_rostime: bool = False
    verbose: bool = False
    times: int = 0
    wait_for: int | None = None
    max_wait_s: float | None = None
    print_nth: int | None = None
    qos_durability: str | None = None
    msg_paths: tuple[Path, ...] = ()
