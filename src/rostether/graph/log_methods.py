"""The log methods that graphs and devices have in common."""

from __future__ import annotations

from abc import abstractmethod

from rostether.graph.ports import Level


class LogMethods:
    """Adds a method for each level to a class with `log`.

    A text with values is formatted with `%`, as in rospy: `loginfo("%.2f m", distance)`.
    """

    @abstractmethod
    def log(self, level: Level, text: str) -> None:
        """Log a text on /rosout."""

    def logdebug(self, text: object, *values: object) -> None:
        """Log at level DEBUG."""
        self.log(Level.DEBUG, _text(text, values))

    def loginfo(self, text: object, *values: object) -> None:
        """Log at level INFO."""
        self.log(Level.INFO, _text(text, values))

    def logwarn(self, text: object, *values: object) -> None:
        """Log at level WARN."""
        self.log(Level.WARN, _text(text, values))

    def logerror(self, text: object, *values: object) -> None:
        """Log at level ERROR."""
        self.log(Level.ERROR, _text(text, values))

    def logfatal(self, text: object, *values: object) -> None:
        """Log at level FATAL."""
        self.log(Level.FATAL, _text(text, values))


def _text(text: object, values: tuple[object, ...]) -> str:
    return str(text) % values if values else str(text)
