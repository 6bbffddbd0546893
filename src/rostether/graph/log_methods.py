"""The log methods that graphs and devices have in common."""

from __future__ import annotations

from abc import abstractmethod

from rostether.graph.ports import Level


class LogMethods:
    """Adds a method for each level to a class with `log`."""

    @abstractmethod
    def log(self, level: Level, text: str) -> None:
        """Log a text on /rosout."""

    def logdebug(self, text: str) -> None:
        """Log at level DEBUG."""
        self.log(Level.DEBUG, text)

    def loginfo(self, text: str) -> None:
        """Log at level INFO."""
        self.log(Level.INFO, text)

    def logwarn(self, text: str) -> None:
        """Log at level WARN."""
        self.log(Level.WARN, text)

    def logerror(self, text: str) -> None:
        """Log at level ERROR."""
        self.log(Level.ERROR, text)

    def logfatal(self, text: str) -> None:
        """Log at level FATAL."""
        self.log(Level.FATAL, text)
