"""Collects the values of a plot, shows them live, and writes a picture at the end."""

from __future__ import annotations

import asyncio
import contextlib
import shutil
import time
from collections.abc import Callable, Coroutine, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from msgspec.structs import replace

from rostether.cli.access.options import msg_path_option
from rostether.cli.plot.curves import Curves, expand
from rostether.cli.shell.option_group import FILE, POSITIVE, flag, option, shared
from rostether.cli.shell.output import warn, write_file, write_line
from rostether.cli.shell.picture_files import encode, picture_format
from rostether.errors import ConfigError, GraphError, SerializationError, first_error
from rostether.mechanisms.tasks import cancel_all
from rostether.mechanisms.text import counted
from rostether.msgdef.registry import Registry
from rostether.pictures.axis import Axis
from rostether.pictures.plot import Curve, Labels, draw_plot
from rostether.pictures.terminal_plot import as_colored, as_plain, plot_lines
from rostether.serde.codec import Codec
from rostether.serde.field_units import unit_of

# Ten pictures a second: movements look smooth, even over a slow SSH connection.
REFRESH_S = 0.1
DEFAULT_WINDOW_S = 10.0

# The fields of one argument, usually of one topic.
Group: TypeAlias = Sequence[str]

Follow: TypeAlias = Callable[[Group], Coroutine[Any, Any, None]]


@dataclass(frozen=True, slots=True)
class PlotOptions:
    """The options of `plot`."""

    window_s: float | None = option(
        "-w --window SECONDS",
        f"Show the last SECONDS (default: {DEFAULT_WINDOW_S:g}; in a file, everything).",
        type=POSITIVE,
    )
    duration_s: float | None = option(
        "--duration SECONDS", "Stop after SECONDS (default: at Ctrl-C).", type=POSITIVE
    )
    file: Path | None = option(
        "-o --output FILE",
        "Write a picture at the end, .svg, or .png with `pip install 'rostether[pictures]'`.",
        type=FILE,
    )
    title: str | None = option("--title TEXT", "The title of the picture (default: the fields).")
    right: tuple[str, ...] = option(
        "--right FIELD",
        "Plot a field with the scale at the right of the picture (default: fields of a second "
        "unit); may be repeated.",
        multiple=True,
    )
    shows_time_of_day: bool = flag("--clock", "Mark the times with the time of day, not with seconds.")
    msg_paths: tuple[Path, ...] = shared(msg_path_option, ())


class PlotSession:
    """Collects values, shows them, and ends with a picture."""

    def __init__(self, options: PlotOptions, *, is_live: bool) -> None:
        self._options = options
        self._is_live = is_live
        self._right = frozenset(name for field in options.right for name in expand(field))
        self._curves = Curves()
        self._begin_s: float | None = None
        self._begin_unix_s = 0.0
        self._types: dict[str, tuple[Registry, Codec]] = {}
        self._problems: set[str] = set()

    def add_type(self, topic: str, registry: Registry, codec: Codec) -> None:
        """Set the type of a topic, which has the units of its fields."""
        self._types[topic] = registry, codec

    def add_message(self, name: str, message: Any, path: Any) -> None:
        """Add the values that a path selects in a message. Raises ConfigError if they are not numbers."""
        now_s = asyncio.get_running_loop().time()
        if self._begin_s is None:
            self._begin_s = now_s
            self._begin_unix_s = time.time()
        try:
            value = message if path is None else path.read(message)
        except SerializationError as error:
            if str(error) not in self._problems:
                self._problems.add(str(error))
                warn(str(error))
            return
        is_empty = isinstance(value, list | bytes) and not value
        if not self._curves.add(now_s - self._begin_s, name, value) and not is_empty:
            raise ConfigError(f"{name} contains no numbers; give a field that does")

    async def run(self, follow: Follow, groups: Sequence[Group]) -> None:
        """Collect all values until the time has passed.

        Raises the first error of `follow`, and GraphError if no value was received.
        """
        loop = asyncio.get_running_loop()
        names = [name for group in groups for name in group]
        self._curves.expect(*names)
        tasks = [loop.create_task(_first_error(follow(group))) for group in groups]
        try:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(self._options.duration_s):
                    if self._is_live:
                        await self._show_live(tasks)
                    else:
                        await asyncio.gather(*tasks)
        finally:
            await cancel_all(*tasks)
            if self._curves.names:
                self._finish()
        if not self._curves.names:
            raise GraphError(f"no value of {', '.join(names)} was received; see `rostether topic echo`")

    def _finish(self) -> None:
        file = self._options.file
        if file is not None:
            since_s = self._last_s - self._options.window_s if self._options.window_s else 0.0
            curves = self._with_scales(self._curves.curves(since_s))
            labels = Labels(self._options.title or "", self._begin_unix_s, self._options.shows_time_of_day)
            write_file(file, encode(draw_plot(curves, labels), picture_format(file)))
            write_line(
                f"{file}: {counted(len(curves), 'curve')}, "
                f"{counted(sum(len(each.points) for each in curves), 'value')}"
            )
        elif not self._is_live:
            for line in as_plain(self._lines(*shutil.get_terminal_size((80, 24)))):
                write_line(line)

    def _with_scales(self, curves: Sequence[Curve]) -> list[Curve]:
        """Return the curves with their units, each on the requested scale or the scale of its unit."""
        with_units = [replace(each, unit=self._unit(each.name)) for each in curves]
        first = next((each.unit for each in with_units if each.unit), "")
        return [
            replace(
                each,
                is_right=_belongs_to(each.name, self._right) if self._right else each.unit not in ("", first),
            )
            for each in with_units
        ]

    def _unit(self, name: str) -> str:
        topic = max((each for each in self._types if _belongs_to(name, [each])), key=len, default=None)
        if topic is None:
            return ""
        registry, codec = self._types[topic]
        return unit_of(registry, codec.tree, name[len(topic) + 1 :])

    @property
    def _last_s(self) -> float:
        return max((curve.points[-1][0] for curve in self._curves.curves() if curve.points), default=0.0)

    def _lines(self, columns: int, rows: int) -> Any:
        whole_s = None if self._is_live else self._options.duration_s
        window_s = self._options.window_s or whole_s or DEFAULT_WINDOW_S
        end_s = max(self._last_s, window_s)
        x_axis = Axis(end_s - window_s, end_s)
        begin_s = self._begin_unix_s if self._options.shows_time_of_day else None
        curves = self._with_scales(self._curves.curves(x_axis.low))
        return plot_lines(curves, columns, rows - 1, x_axis, begin_s)

    async def _show_live(self, tasks: Sequence[asyncio.Task[None]]) -> None:
        from rich.console import Console
        from rich.live import Live

        console = Console()
        with Live(console=console, auto_refresh=False, screen=False) as live:
            while True:
                if self._curves.names:
                    lines = self._lines(console.width, console.height - 1)
                    live.update(as_colored(lines, "Ctrl-C ends it"), refresh=True)
                done, _ = await asyncio.wait(tasks, timeout=REFRESH_S, return_when=asyncio.FIRST_EXCEPTION)
                for task in done:
                    task.result()
                if len(done) == len(tasks):
                    return


def _belongs_to(name: str, fields: Iterable[str]) -> bool:
    """Return whether a curve belongs to one of the topics or fields."""
    return any(name == each or name.startswith((f"{each}/", f"{each}[")) for each in fields)


async def _first_error(work: Coroutine[Any, Any, None]) -> None:
    """Run a task group, and raise its first error instead of an exception group."""
    try:
        await work
    except BaseExceptionGroup as problems:
        raise first_error(problems) from None
