"""The common part of `topic echo` on ROS 1 and ROS 2: the filter, the count, and the field."""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

from rostether.cli.shell.output import warn, write_json
from rostether.cli.topic.options import EchoOptions
from rostether.errors import SerializationError

if TYPE_CHECKING:
    from rostether.serde.field_path import FieldPath

# The sequence that rostopic writes.
CLEAR_SCREEN = "\033[2J\033[;H"


class EchoPrinter(ABC):
    """Prints messages in one style and counts them; `received_count` includes those that the filter omits."""

    def __init__(self, topic: str, options: EchoOptions) -> None:
        self.options = options
        self.received_count = 0
        self.shown_count = 0
        # The field to print, None for whole messages.
        self.path: FieldPath | None = None
        self._topic = topic
        self._filter = options.compiled_filter()
        self._reported_problem = ""

    @property
    def is_done(self) -> bool:
        """Whether as many messages as wanted have been printed."""
        return self.options.wanted_count is not None and self.shown_count >= self.options.wanted_count

    def print_message(self, message: Any) -> None:
        """Print a message, or its field at `path`, unless the filter omits the message."""
        self.received_count += 1
        if self._filter is not None and not self._filter(message, self._topic):
            return
        try:
            value = message if self.path is None else self.path.read(message)
        except SerializationError as error:
            if str(error) != self._reported_problem:
                self._reported_problem = str(error)
                warn(self._reported_problem)
            return
        self.shown_count += 1
        if self.options.clear and not (self.options.as_json or self.options.plot or self.options.csv):
            sys.stdout.write(CLEAR_SCREEN)
        if self.options.as_json:
            from rostether.serde.plain_form import plain_value

            plain = plain_value(value)
            write_json(plain if isinstance(plain, dict) else {"value": plain})
        else:
            self.write_text(value)

    @abstractmethod
    def write_text(self, value: Any) -> None:
        """Print a message or a field of it."""
