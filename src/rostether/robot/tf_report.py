"""Formats the content of a tf buffer: the tree of frames as text or for Graphviz, and single transforms."""

from __future__ import annotations

import math
from collections.abc import Iterator

from msgspec import Struct

from rostether.pictures.digraph import quoted
from rostether.pictures.tree import branch
from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.transform import StampedTransform, rpy_from_quaternion
from rostether.rostime import NS_PER_S


class FrameFacts(Struct, frozen=True):
    """One frame with a parent: its broadcaster, its rate, and the time span of its transforms."""

    frame: str
    parent: str
    broadcaster: str
    rate_hz: float
    latest_s: float
    oldest_s: float
    is_static: bool

    @property
    def buffer_length_s(self) -> float:
        """The length of the stored history."""
        return self.latest_s - self.oldest_s


def frame_facts(buffer: TransformBuffer) -> list[FrameFacts]:
    """Return the facts of all frames with a parent, in the order of their first appearance."""
    facts = []
    for frame in buffer.children:
        cache = buffer.cache_of(frame)
        assert cache is not None
        facts.append(
            FrameFacts(
                frame,
                cache.latest.parent,
                cache.latest.authority,
                cache.rate_hz,
                cache.latest_ns / NS_PER_S,
                cache.oldest_ns / NS_PER_S,
                cache.is_static,
            )
        )
    return facts


def frames_as_dot(buffer: TransformBuffer) -> str:
    """Return the tree in the dot language of Graphviz, like view_frames."""
    lines = ["digraph G {"]
    for each in frame_facts(buffer):
        label = "\n".join(
            (
                f"Broadcaster: {each.broadcaster}",
                "static" if each.is_static else f"Average rate: {each.rate_hz:.3f} Hz",
                f"Most recent transform: {each.latest_s:.3f}",
                f"Buffer length: {each.buffer_length_s:.3f} sec",
            )
        )
        lines.append(f"{quoted(each.parent)} -> {quoted(each.frame)} [label={quoted(label)}];")
    return "\n".join([*lines, "}"])


def frame_tree(buffer: TransformBuffer) -> Iterator[str]:
    """Yield the tree of frames line by line, each below its parent; frames in a loop come last."""
    facts = {each.frame: each for each in frame_facts(buffer)}
    below: dict[str, list[str]] = {}
    for each in facts.values():
        below.setdefault(each.parent, []).append(each.frame)
    shown: set[str] = set()

    def show(root: str) -> Iterator[str]:
        waiting = [(root, "", "")]
        while waiting:
            frame, lead, indent = waiting.pop()
            shown.add(frame)
            yield lead + frame + _described(facts.get(frame))
            children = [child for child in sorted(below.get(frame, ())) if child not in shown]
            for index, child in reversed(list(enumerate(children))):
                waiting.append((child, *branch(indent, is_last=index == len(children) - 1)))

    for frame in buffer.frames:
        if frame not in facts:
            yield from show(frame)
    for frame in facts:
        if frame not in shown:
            yield f"(loop: {frame} is above itself)"
            yield from show(frame)


def format_transform(stamped: StampedTransform) -> str:
    """Return a transform as tf_echo prints it."""
    rotation = stamped.transform.rotation
    rpy = rpy_from_quaternion(rotation)
    return "\n".join(
        (
            f"At time {stamped.stamp_ns / NS_PER_S:.3f}",
            f"- Translation: {_numbers(stamped.transform.translation)}",
            f"- Rotation: in Quaternion {_numbers(rotation)}",
            f"            in RPY (radian) {_numbers(rpy)}",
            f"            in RPY (degree) {_numbers(tuple(map(math.degrees, rpy)))}",
        )
    )


def _described(facts: FrameFacts | None) -> str:
    if facts is None:
        return ""
    how = "static" if facts.is_static else f"{facts.rate_hz:.1f} Hz" if facts.buffer_length_s else "once"
    return f"  ({how}, {facts.broadcaster})"


def _numbers(numbers: tuple[float, ...]) -> str:
    return f"[{', '.join(f'{each:.3f}' for each in numbers)}]"
