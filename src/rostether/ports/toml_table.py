"""Reads one table of a TOML file key by key; errors are one line with file and key."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from rostether.errors import ConfigError, InvalidNameError
from rostether.names.graph_name import validate_name

# The limit of boards, topics or patterns: more than a user types; it bounds each search.
MAX_ENTRIES = 1000
# More items of a list do not fit in an error.
_SHOWN_ITEMS = 20


class TomlTable:
    """A table and its path in the file; getters return None or an empty value for a missing key.

    The getters raise ConfigError, and so does the constructor for keys that are not in `known` (None: any).
    """

    def __init__(self, file: str, key_path: str, content: object, *, known: Sequence[str] | None) -> None:
        self._file = file
        self._key_path = key_path
        if not isinstance(content, dict):
            raise self.error(f"must be a table, not {_show(content)}")
        if len(content) > MAX_ENTRIES:
            raise self.error(f"has {len(content)} entries; at most {MAX_ENTRIES} are allowed")
        self._content: Mapping[str, object] = content
        for key in content:
            if known is not None and key not in known:
                raise self.error(f"unknown key; known: {', '.join(known)}", key)

    @property
    def is_given(self) -> bool:
        """Whether the table is not empty."""
        return bool(self._content)

    def error(self, text: str, key: str | None = None) -> ConfigError:
        """Return the error to raise for a key, or for the table itself."""
        return self._error_at(self._at(key) if key is not None else self._key_path, text)

    def _error_at(self, key_path: str, text: str) -> ConfigError:
        return ConfigError(f"{self._file}:{key_path}: {text}")

    def table(self, key: str, *, known: Sequence[str] | None = None) -> TomlTable:
        """Return a nested table, empty if it is missing."""
        return TomlTable(self._file, self._at(key), self._content.get(key, {}), known=known)

    def tables(self, key: str, *, known: Sequence[str]) -> Iterator[tuple[str, TomlTable]]:
        """Yield the tables inside a nested table, with their keys."""
        outer = self.table(key)
        for name in outer._content:
            yield name, outer.table(name, known=known)

    def lines(self) -> dict[str, str]:
        """Return all values of the table by key: each is one line of text."""
        return {key: self.line(key) or "" for key in self._content}

    def check_name(self, name: str) -> None:
        """Check that the table's own key is a node name."""
        self._check_graph_name(name, self._key_path)

    def text(self, key: str, fits: Callable[[str], object] = bool, hint: str = "a text") -> str | None:
        """Return a string that `fits`."""
        value = self._content.get(key)
        if value is None or (isinstance(value, str) and fits(value)):
            return value
        raise self.error(f"write {hint}, not {_show(value)}", key)

    def line(self, key: str) -> str | None:
        """Return a string without line ends."""
        return self.text(key, _is_line, "one line of text in quotes")

    def texts(self, key: str, fits: Callable[[str], bool], hint: str) -> list[str]:
        """Return a list of strings that all fit."""
        for value in self._list(key):
            if not (isinstance(value, str) and fits(value)):
                raise self.error(f"write {hint}, not {_show(value)}", key)
        return [str(value) for value in self._list(key)]

    def whole(self, key: str, lowest: int, highest: int) -> int | None:
        """Return a whole number within bounds."""
        value = self._content.get(key)
        return None if value is None else self._whole(value, self._at(key), lowest, highest)

    def number(self, key: str, lowest: float, highest: float) -> float | None:
        """Return a number within bounds."""
        value = self._content.get(key)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, int | float) or not lowest <= value <= highest:
            raise self.error(f"write a number from {lowest:g} to {highest:g}, not {_show(value)}", key)
        return float(value)

    def flag(self, key: str) -> bool | None:
        """Return a boolean."""
        value = self._content.get(key)
        if value is None or isinstance(value, bool):
            return value
        raise self.error(f"write true or false, not {_show(value)}", key)

    def graph_name(self, key: str) -> str | None:
        """Return a ROS name."""
        value = self._content.get(key)
        return None if value is None else self._check_graph_name(value, self._at(key))

    def graph_names(self, key: str) -> tuple[str, ...] | None:
        """Return a list of ROS names."""
        if key not in self._content:
            return None
        return tuple(self._check_graph_name(value, self._at(key)) for value in self._list(key))

    def name_patterns(self, key: str) -> tuple[str, ...] | None:
        """Return a list of full names that may contain `*`."""
        if key not in self._content:
            return None
        patterns = self.texts(key, _is_name_pattern, 'full names such as "/imu" or "/arm/*"')
        return tuple(patterns)

    def names_to_names(self, key: str) -> dict[str, str]:
        """Return a table of ROS names."""
        entries = self._entries(key)
        return {
            self._check_graph_name(name, key_path): self._check_graph_name(value, key_path)
            for name, value, key_path in entries
        }

    def names_to_numbers(self, key: str, lowest: int, highest: int) -> dict[str, int]:
        """Return a table of whole numbers by ROS name."""
        entries = self._entries(key)
        return {
            self._check_graph_name(name, key_path): self._whole(value, key_path, lowest, highest)
            for name, value, key_path in entries
        }

    def _entries(self, key: str) -> Iterator[tuple[str, object, str]]:
        inner = self.table(key)
        for name, value in inner._content.items():
            yield name, value, inner._at(name)

    def _at(self, key: str) -> str:
        shown = key if key.replace("_", "").replace("-", "").isalnum() else repr(key)
        return f"{self._key_path}.{shown}" if self._key_path else shown

    def _list(self, key: str) -> list[object]:
        value = self._content.get(key, [])
        if not isinstance(value, list):
            raise self.error(f"write a list in brackets, not {_show(value)}", key)
        if len(value) > MAX_ENTRIES:
            raise self.error(f"has {len(value)} entries; at most {MAX_ENTRIES} are allowed", key)
        return value

    def _whole(self, value: object, key_path: str, lowest: int, highest: int) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not lowest <= value <= highest:
            raise self._error_at(
                key_path, f"write a whole number from {lowest} to {highest}, not {_show(value)}"
            )
        return value

    def _check_graph_name(self, value: object, key_path: str) -> str:
        if not isinstance(value, str) or not value:
            raise self._error_at(key_path, f"write a ROS name such as /arm/imu, not {_show(value)}")
        try:
            return validate_name(value)
        except InvalidNameError as error:
            raise self._error_at(key_path, str(error)) from None


def _is_line(text: str) -> bool:
    return "\n" not in text and "\0" not in text


def _is_name_pattern(text: str) -> bool:
    return text.startswith(("/", "*")) and all(
        char.isascii() and (char.isalnum() or char in "/_*") for char in text
    )


def _show(value: object) -> str:
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, bool):
        text = "true" if value else "false"
    elif isinstance(value, list):
        text = f"[{', '.join(map(_show, value[:_SHOWN_ITEMS]))}]"
    else:
        # Dates and times look the same in TOML and as a Python string.
        text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
