"""`rostether bag play`: publishes recordings on the graph, with keys to pause and to step."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import ExitStack, asynccontextmanager, closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option
from rostether.cli.access.ros1_access import read_environment, resolve
from rostether.cli.bag.progress import show
from rostether.cli.bag.recording_files import recording_graph, warn_of_damage
from rostether.cli.shell.keys import typed_keys
from rostether.cli.shell.option_group import (
    NOT_NEGATIVE,
    POSITIVE,
    flag,
    ignored_options,
    option,
    option_group,
    shared,
)
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.block_end import task_beside
from rostether.mechanisms.tasks import run_until
from rostether.mechanisms.text import counted, did_you_mean
from rostether.rostime import NS_PER_S

if TYPE_CHECKING:
    from rostether.recording.player import Player, PlaySettings

# The time on the line seems to run continuously.
_PROGRESS_PERIOD_S = 0.1
_KEYS_SHOWN = "Space pauses, s plays one message while paused, q quits."


@dataclass(frozen=True, slots=True)
class PlayOptions:
    """The options of `bag play`."""

    rate: float = option(
        "-r --rate", "Speed relative to the recording (default: 1).", type=POSITIVE, default=1.0
    )
    start_s: float = option(
        "-s --start --start-offset SEC", "Start SEC seconds after the beginning.", type=float, default=0.0
    )
    duration_s: float | None = option(
        "-u --duration --playback-duration SEC", "Play only SEC seconds.", type=NOT_NEGATIVE
    )
    is_looping: bool = flag("-l --loop", "Start again at the end.")
    immediate: bool = flag("-i --immediate", "Play as fast as possible.")
    is_paused: bool = flag("--pause --start-paused", "Start paused.")
    with_clock: bool = flag("--clock", "Publish the recorded time on /clock.")
    clock_hz: float = option(
        "--hz", "The rate of /clock, in Hz (default: 100).", type=POSITIVE, default=100.0
    )
    topics: tuple[str, ...] = option(
        "--topics TOPIC", "Play only these topics; accepts several.", multiple=True
    )
    pause_topics: tuple[str, ...] = option(
        "--pause-topics TOPIC", "Pause at each message of these topics.", multiple=True
    )
    bags: tuple[str, ...] = option(
        "--bags FILE", "The recordings, if --topics comes before them.", multiple=True
    )
    prefix: str = option("-p --prefix NAME", "Put all topics in the namespace NAME.", default="")
    skip_empty_s: float | None = option("--skip-empty SEC", "Skip gaps longer than SEC.", type=NOT_NEGATIVE)
    delay_s: float = option(
        "-d --delay SEC",
        "Wait SEC seconds for subscribers to connect (default: 0.2).",
        type=NOT_NEGATIVE,
        default=0.2,
    )
    wait_for_subscribers: bool = flag("--wait-for-subscribers", "Start when every topic has a subscriber.")
    keep_alive: bool = flag("-k --keep-alive", "Keep running at the end, for latched topics.")
    queue_messages: int | None = option(
        "--queue COUNT",
        "Queue up to COUNT messages per topic for slow subscribers (default: 4 MB).",
        type=click.IntRange(min=0),
    )
    rate_control_topic: str | None = option(
        "--rate-control-topic TOPIC", "Pause if TOPIC is silent for longer than --rate-control-max-delay."
    )
    rate_control_max_delay_s: float = option(
        "--rate-control-max-delay SEC",
        "The longest silence of --rate-control-topic, in seconds (default: 1).",
        type=NOT_NEGATIVE,
        default=1.0,
    )
    quiet: bool = flag("-q --quiet", "Print only errors.")
    msg_paths: tuple[Path, ...] = shared(msg_path_option, ())


@verb(
    "play",
    """
    rostether bag play drive.bag
    rostether bag play drive.bag --rate 4 --start 10 --duration 5 --loop
    rostether bag play drive.bag --clock --topics /ultrasound /imu_data
    rostether bag play drive.bag /ultrasound:=/old/ultrasound
    rostether bag play --ros2 zenoh rosbag2_2026-11-20-10-00-00
    """,
)
@option_group("options", PlayOptions)
@click.argument("files", nargs=-1, metavar="FILE... [FROM:=TO]...")
@ignored_options("--read-ahead-queue-size", flags=["--try-future-version", "-m --remap"])
@graph_options(allow=True, zenoh=True)
def bag_play(options: PlayOptions, files: tuple[str, ...], graph: GraphOptions) -> None:
    """Publish the messages of recordings at their recorded times. Space pauses, s steps, q quits.

    With --clock, nodes use the recorded time if /use_sim_time is set to true before they start.
    """
    from rostether.recording.player import PlaySettings

    environment, topics = read_environment(graph), options.topics
    plain = [*files, *options.bags]
    remappings = dict(each.split(":=", 1) for each in plain if ":=" in each and not each.startswith("_"))
    given = [each for each in plain if ":=" not in each]
    if topics:
        # As in rosbag, `--topics /a /b`: words that are not files are topics.
        topics = (*topics, *(each for each in given if each.startswith("/") and not Path(each).exists()))
        given = [each for each in given if not each.startswith("/") or Path(each).exists()]
    if not given:
        raise click.UsageError("name a file to play")

    def full(name: str) -> str:
        return resolve(name, environment)

    settings = PlaySettings(
        rate=options.rate,
        start_s=options.start_s,
        duration_s=options.duration_s,
        is_immediate=options.immediate,
        is_looping=options.is_looping,
        starts_paused=options.is_paused,
        skip_empty_s=options.skip_empty_s,
        delay_s=options.delay_s,
        clock_hz=options.clock_hz if options.with_clock else None,
        queue_messages=options.queue_messages,
        rate_control_topic=full(options.rate_control_topic) if options.rate_control_topic else "",
        rate_control_max_delay_s=options.rate_control_max_delay_s,
        waits_for_subscribers=options.wait_for_subscribers,
        pause_topics=frozenset(map(full, options.pause_topics)),
        topics=frozenset(map(full, topics)),
        prefix=full(options.prefix) if options.prefix else "",
        remappings={full(old): full(new) for old, new in remappings.items()},
    )
    run(_play(graph, [Path(each) for each in given], settings, options))


async def _play(
    graph_options: GraphOptions, paths: list[Path], settings: PlaySettings, options: PlayOptions
) -> None:
    from rostether.recording.files import open_recording
    from rostether.recording.player import Player

    with ExitStack() as opened:
        is_native = graph_options.is_ros2_alone
        readers = [opened.enter_context(closing(open_recording(path, is_native=is_native))) for path in paths]
        for path, reader in zip(paths, readers, strict=True):
            warn_of_damage(path, reader.damage)
            for topic, why in reader.unreadable.items():
                warn(f"{path}: {topic} is skipped: {why}")
        connections = [each for reader in readers for each in reader.counts]
        _check_topics(settings, {each.topic for each in connections})
        origins = [each.origin for each in connections if each.origin is not None]
        async with recording_graph(
            graph_options, "play", is_native=is_native, origins=origins, msg_paths=options.msg_paths
        ) as graph:
            player = Player(graph.raw, readers, settings)
            if settings.start_s > player.length_s:
                warn(
                    f"WARNING: --start {settings.start_s:g} is after the end; the recording lasts "
                    f"{player.length_s:.3f} s; nothing is played"
                )
            playing = asyncio.create_task(player.play())
            async with _keys(player, playing.cancel, is_quiet=options.quiet):
                await run_until(playing, graph.raw.wait_closed())
                if options.keep_alive and not playing.cancelled():
                    await player.keep_clock()
            if not options.quiet:
                write_line(f"played {counted(player.played_count, 'message')}")


def _check_topics(settings: PlaySettings, recorded: set[str]) -> None:
    missing = sorted((settings.topics | settings.pause_topics) - recorded)
    if missing:
        hint = did_you_mean(missing[0], recorded) or "`rostether bag info` lists its topics"
        raise ConfigError(f"the recording has no topic {missing[0]}; {hint}")


@asynccontextmanager
async def _keys(player: Player, end: Callable[[], object], *, is_quiet: bool) -> AsyncIterator[None]:
    """Handle keys and show the progress during the block, if there is a terminal; `end` ends the playback."""

    def press(typed: bytes) -> None:
        for key in typed.decode(errors="replace"):
            if key == " ":
                player.toggle_pause()
            elif key == "s":
                player.step()
            elif key == "q":
                end()

    with typed_keys(press) as has_keys:
        is_shown = has_keys and not is_quiet
        if is_shown:
            write_line(_KEYS_SHOWN)
        if not is_shown or not sys.stderr.isatty():
            yield
            return
        try:
            async with task_beside(_show(player)):
                yield
        finally:
            show("")


async def _show(player: Player) -> None:
    span_s = (player.end_ns - player.start_ns) / NS_PER_S
    while True:
        word = "PAUSED " if player.is_paused else "RUNNING"
        passed_s = max(player.time_ns - player.start_ns, 0) / NS_PER_S
        line = f"[{word}]  time {player.time_ns / NS_PER_S:.3f}   {passed_s:.2f} of {span_s:.2f} s"
        show(f"{line}   {counted(player.played_count, 'message')}")
        await asyncio.sleep(_PROGRESS_PERIOD_S)
