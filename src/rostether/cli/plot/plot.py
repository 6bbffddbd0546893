"""`rostether plot`: values of topics over time, live in the terminal or into a picture, as rqt_plot shows."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import sys
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import click

from rostether.cli.access.completions import complete_fields
from rostether.cli.access.graph_options import TOOL_ALLOW, GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option
from rostether.cli.access.refusals import refuse_ros1_only
from rostether.cli.plot.curves import Curves, expand
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.picture_files import encode, picture_format, save
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.cli.topic.misfit_notice import shown_messages
from rostether.errors import ConfigError, GraphError, SerializationError, first_error

if TYPE_CHECKING:
    from rostether.serde.codec import Codec

REFRESH_S = 0.1
DEFAULT_WINDOW_S = 10.0
MAX_ARGUMENTS = 28  # as many as there are curves, see `plot_curves`

_Group: TypeAlias = Sequence[str]
"""Fields that one argument names, as a rule of one topic."""

_Follow: TypeAlias = Callable[[_Group], Coroutine[Any, Any, None]]


@dataclass(frozen=True, slots=True)
class _Options:
    window_s: float | None
    duration_s: float | None
    file: Path | None
    is_live: bool


@click.command(
    "plot",
    cls=Verb,
    old_options={"--for": "--duration", "--save": "--output"},
    examples="""
    rostether plot /ultrasound/range
    rostether plot /imu_data/angular_velocity/x:y:z
    rostether plot "/joint_states/position[0:4]" --window 30
    rostether plot /joint_states/position --duration 20 --output joints.png
    """,
)
@click.argument(
    "fields", nargs=-1, required=True, metavar="TOPIC[/FIELD[:FIELD]]...", shell_complete=complete_fields
)
@click.option(
    "-w",
    "--window",
    "window_s",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help=f"Show the last SECONDS (default: {DEFAULT_WINDOW_S:g}; in a file, everything).",
)
@click.option(
    "--duration",
    "duration_s",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Stop after SECONDS (default: at Ctrl-C).",
)
@click.option(
    "-o",
    "--output",
    "file",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Write a picture at the end, .svg, or .png with `pip install 'rostether[pictures]'`.",
)
@msg_path_option
@graph_options(allow=TOOL_ALLOW)
def plot(
    fields: tuple[str, ...],
    window_s: float | None,
    duration_s: float | None,
    file: Path | None,
    msg_paths: tuple[Path, ...],
    graph: GraphOptions,
) -> None:
    """Plot values of topics over their time of arrival.

    A FIELD is written as for `topic echo`; colons separate more fields of the same message. For an array or a
    message, every number in it is plotted. Without a terminal, the plot is printed once, at the end. The
    command waits for topics that do not exist yet.
    """
    if file is not None:
        picture_format(file, (".png", ".svg"))
    targets = [expand(field) for field in dict.fromkeys(fields)]
    if sum(map(len, targets)) > MAX_ARGUMENTS:
        raise click.UsageError(f"at most {MAX_ARGUMENTS} fields can be plotted")
    is_terminal = sys.stdout.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")
    if not is_terminal and file is None and duration_s is None:
        duration_s = window_s or DEFAULT_WINDOW_S
    options = _Options(window_s, duration_s, file, is_terminal)
    if graph.ros2 is not None:
        refuse_ros1_only(master=graph.master)
        run(_plot_ros2(graph, targets, options, msg_paths))
    else:
        run(_plot_ros1(graph, targets, options, msg_paths))


async def _plot_ros1(
    graph_options: GraphOptions,
    targets: Sequence[_Group],
    options: _Options,
    msg_paths: tuple[Path, ...],
) -> None:
    from rostether.cli.access.ros1_access import in_namespace, joined, read_environment
    from rostether.cli.topic.ros1_chosen_topic import resolve_with_field, wait_for_topic
    from rostether.serde.field_path import FieldPath

    environment = read_environment(graph_options)
    groups = [[resolve_with_field(target, environment) for target in group] for group in targets]
    async with joined(graph_options, msg_paths, purpose="plot") as graph:
        session = _Session(options)

        async def follow(group: Sequence[str]) -> None:
            topic = (await wait_for_topic(group[0], graph.store, environment)).topic
            here = [name for name in group if in_namespace(name, topic)]
            async with asyncio.TaskGroup() as tasks:
                if others := [name for name in group if name not in here]:
                    tasks.create_task(follow(others))
                tasks.create_task(follow_topic(topic, here))

        async def follow_topic(topic: str, group: Sequence[str]) -> None:
            stream = graph.messages(topic)
            codec: Codec | None = None
            paths: dict[str, FieldPath | None] = {}
            async with shown_messages(stream) as messages:
                async for message in messages:
                    if stream.codec is not codec:
                        assert stream.codec is not None
                        codec = stream.codec
                        fields = {name: name[len(topic) + 1 :] for name in group}
                        paths = {
                            name: FieldPath(codec, field) if field else None for name, field in fields.items()
                        }
                    for name, path in paths.items():
                        session.add_message(name, message, path)

        await session.run(follow, groups)


async def _plot_ros2(
    graph_options: GraphOptions,
    targets: Sequence[_Group],
    options: _Options,
    msg_paths: tuple[Path, ...],
) -> None:
    from rostether.cli.access.ros2_tool_node import tool_node
    from rostether.cli.topic.ros2_chosen_topic import choose_topic

    async with tool_node(graph_options, msg_paths) as tool:
        session = _Session(options)

        async def follow(group: Sequence[str]) -> None:
            async with asyncio.TaskGroup() as tasks:
                for name in group:
                    tasks.create_task(follow_one(name))

        async def follow_one(name: str) -> None:
            chosen = await choose_topic(tool, name)
            path = None if chosen.field is None else chosen.field.path
            async with shown_messages(tool.graph.messages(chosen.topic, chosen.type)) as messages:
                async for message in messages:
                    session.add_message(name, message, path)

        await session.run(follow, targets)


class _Session:
    """Collects values, shows them, and ends with a picture."""

    def __init__(self, options: _Options) -> None:
        self._options = options
        self._curves = Curves()
        self._begin_s: float | None = None
        self._problems: set[str] = set()

    def add_message(self, name: str, message: Any, path: Any) -> None:
        """Add the values that a path selects in a message. Raises ConfigError if they are not numbers."""
        now_s = asyncio.get_running_loop().time()
        if self._begin_s is None:
            self._begin_s = now_s
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

    async def run(self, follow: _Follow, groups: Sequence[_Group]) -> None:
        """Follow all values until the time is over. Raises what following one of them raises."""
        loop = asyncio.get_running_loop()
        names = [name for group in groups for name in group]
        self._curves.expect(*names)
        tasks = [loop.create_task(_first_problem(follow(group))) for group in groups]
        try:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(self._options.duration_s):
                    if self._options.is_live:
                        await self._show_live(tasks)
                    else:
                        await asyncio.gather(*tasks)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            if self._curves.names:
                self._finish()
        if not self._curves.names:
            raise GraphError(f"no value was received of {', '.join(names)}; see `rostether topic echo`")

    def _finish(self) -> None:
        file = self._options.file
        if file is not None:
            from rostether.pictures.plot import draw_plot

            since_s = self._last_s - self._options.window_s if self._options.window_s else 0.0
            curves = self._curves.curves(since_s)
            save(file, encode(draw_plot(curves), picture_format(file)))
            write_line(f"{file}: {len(curves)} curves, {sum(len(each.points) for each in curves)} values")
        elif not self._options.is_live:
            from rostether.cli.plot.view import as_plain

            for line in as_plain(self._lines(*shutil.get_terminal_size((80, 24)))):
                write_line(line)

    @property
    def _last_s(self) -> float:
        return max((curve.points[-1][0] for curve in self._curves.curves() if curve.points), default=0.0)

    def _lines(self, columns: int, rows: int) -> Any:
        from rostether.cli.plot.view import plot_lines
        from rostether.pictures.axis import Axis

        whole_s = None if self._options.is_live else self._options.duration_s
        window_s = self._options.window_s or whole_s or DEFAULT_WINDOW_S
        end_s = max(self._last_s, window_s)
        across = Axis(end_s - window_s, end_s)
        return plot_lines(self._curves.curves(across.low), columns, rows - 1, across)

    async def _show_live(self, tasks: Sequence[asyncio.Task[None]]) -> None:
        from rich.console import Console
        from rich.live import Live

        from rostether.cli.plot.view import as_colored

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


async def _first_problem(work: Coroutine[Any, Any, None]) -> None:
    """Do what a task group does, and raise its first error instead of a group of them."""
    try:
        await work
    except BaseExceptionGroup as problems:
        raise first_error(problems) from None
