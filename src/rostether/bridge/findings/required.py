"""Topics that devices.toml requires of a board and that the board does not announce."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from rostether.bridge.findings.finding import Code, Finding, error
from rostether.errors import InvalidNameError
from rostether.mechanisms.text import listed

# More topics would not fit on a line.
_LISTED_ANNOUNCED = 8


class RequiredTopics:
    """The topics that devices.toml requires; `resolve` makes full names, remapped ones included."""

    def __init__(self, names: Sequence[str] = (), resolve: Callable[[str], str] = str) -> None:
        self._required = {resolve(name): name for name in names}
        self._resolve = resolve
        self._missing: tuple[str, ...] = ()
        self._announced: tuple[str, ...] = ()

    def forget(self) -> None:
        """Forget the missing topics, when a connection starts."""
        self._missing = ()

    def compare(self, announced: Iterable[str]) -> None:
        """Find the missing topics; `announced` are all topics of the board."""
        if self._required:
            self._announced = tuple(dict.fromkeys(announced))
            there = {self._full_name(name) for name in self._announced}
            self._missing = tuple(name for full, name in self._required.items() if full not in there)

    def find(self) -> Iterator[Finding]:
        """Yield the finding, if topics are missing."""
        if self._missing:
            shown = listed(self._announced, _LISTED_ANNOUNCED) or "no topic"
            yield error(
                Code.MISSING_TOPIC,
                f"the board does not announce {', '.join(self._missing)}, which devices.toml requires; it "
                f"announces {shown}",
                "flash the right sketch, add the topic to it, or correct required_topics",
            )

    def _full_name(self, name: str) -> str:
        try:
            return self._resolve(name)
        except InvalidNameError:
            return name
