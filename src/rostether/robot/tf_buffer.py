"""The tf buffer: stores transforms, and computes the transform between any two frames at a time.

Frames form a tree: each has one parent at a time. A lookup follows the parents of both frames until the paths
meet, and interpolates each step to the requested time. Errors have the same texts as in tf2, because users
search for them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from rostether.errors import ExtrapolationError, TransformError, UnconnectedFramesError, UnknownFrameError
from rostether.robot.tf_cache import DEFAULT_CACHE_NS, StaticCache, StoredTransform, TimeCache
from rostether.robot.transform import (
    StampedTransform,
    Transform,
    has_unit_length,
    matrix_from_quaternion,
    quaternion_from_matrix,
)

# The limit of steps to the root, as in tf2: a longer path is a loop.
MAX_DEPTH = 1_000

# Enough for hundreds of robots; peers choose the names, and each name uses memory permanently.
MAX_FRAMES = 10_000

# Real names are a few words with a prefix; a name of 100 MB must not stay in memory.
MAX_FRAME_NAME_LENGTH = 1_024


class TransformBuffer:
    """The transforms of a tree of frames over the last seconds.

    Times are in nanoseconds; zero means the latest.
    """

    def __init__(self, cache_ns: int = DEFAULT_CACHE_NS) -> None:
        self._cache_ns = cache_ns
        self._caches: dict[str, TimeCache | StaticCache] = {}
        # The names of all frames, in the order of their first appearance, as in tf2.
        self._frames: dict[str, None] = {}

    def set_transform(
        self, stamped: StampedTransform, *, authority: str = "", is_static: bool = False
    ) -> str:
        """Store a transform; return tf2's error message if it was refused, or an empty string.

        `authority` is the name of the node that sent it. The first transform of a frame determines whether
        the frame is moving or static.
        """
        parent, child = stamped.parent.removeprefix("/"), stamped.child.removeprefix("/")
        problem = _defect(parent, child, stamped.transform, authority)
        if problem:
            return problem
        if len(self._frames) >= MAX_FRAMES and not {parent, child} <= self._frames.keys():
            return (
                f'TF_TOO_MANY_FRAMES: Ignoring "{child}" from authority "{authority}": {MAX_FRAMES} are known'
            )
        entry = StoredTransform(stamped.stamp_ns, parent, stamped.transform, authority)
        self._frames.setdefault(child)
        cache = self._caches.get(child)
        if cache is None:
            cache = self._caches[child] = StaticCache(entry) if is_static else TimeCache(self._cache_ns)
        refusal = cache.insert(entry)
        if refusal:
            at = stamped.stamp_ns / 1e9
            return f"{refusal} for frame {child} at time {at:.6f} according to authority {authority}"
        self._frames.setdefault(parent)
        return ""

    def lookup(self, target: str, source: str, time_ns: int = 0) -> StampedTransform:
        """Return the transform from `source` to `target`; time zero is the latest common time of all steps.

        Raises UnknownFrameError, UnconnectedFramesError, ExtrapolationError, TransformError.
        """
        if source == target:
            # As in tf2, even for an unknown frame.
            cache = self._caches.get(target)
            at = cache.latest_ns if cache is not None and time_ns == 0 else time_ns
            return StampedTransform(target, source, at, Transform())
        self._check(target, "lookupTransform argument target_frame")
        self._check(source, "lookupTransform argument source_frame")
        if time_ns == 0:
            time_ns = self.latest_common_time_ns(target, source)
        return StampedTransform(target, source, time_ns, self._walk(target, source, time_ns))

    def lookup_through(
        self, target: str, target_time_ns: int, source: str, source_time_ns: int, fixed: str
    ) -> StampedTransform:
        """Return the transform from `source` at one time to `target` at another, through the frame `fixed`.

        Raises the same errors as `lookup`.
        """
        for frame, role in ((target, "target"), (source, "source"), (fixed, "fixed")):
            self._check(frame, f"lookupTransform argument {role}_frame")
        second = self.lookup(fixed, source, source_time_ns)
        first = self.lookup(target, fixed, target_time_ns)
        # tf2 uses matrices for this step, which normalizes rotations and determines their signs.
        joined = first.transform.normalized() @ second.transform.normalized()
        rotation = quaternion_from_matrix(matrix_from_quaternion(joined.rotation))
        return StampedTransform(target, source, first.stamp_ns, Transform(joined.translation, rotation))

    def lookup_error(self, target: str, source: str, time_ns: int = 0) -> str:
        """Return why `lookup` would fail, or an empty string."""
        unknown = [
            f"canTransform: {role} {frame} does not exist."
            for frame, role in ((target, "target_frame"), (source, "source_frame"))
            if frame not in self._frames and frame and not frame.startswith("/") and target != source
        ]
        if unknown:
            return " ".join(unknown)
        try:
            self.lookup(target, source, time_ns)
        except TransformError as error:
            return str(error)
        return ""

    def latest_common_time_ns(self, target: str, source: str) -> int:
        """Return the latest time at which every step between two frames is known; 0 if all steps are static.

        Raises UnknownFrameError, UnconnectedFramesError.
        """
        self._check(target, "getLatestCommonTime argument target_frame")
        self._check(source, "getLatestCommonTime argument source_frame")
        if target == source:
            cache = self._caches.get(source)
            return cache.latest_ns if cache is not None else 0
        passed = self.chain(target, source)
        # The common ancestor adds no step.
        ancestor = self._common_ancestor(target, source)
        stamps = [self._caches[frame].latest_ns for frame in passed if frame != ancestor]
        return min((stamp for stamp in stamps if stamp), default=0)

    def chain(self, target: str, source: str) -> list[str]:
        """Return the frames on the path of a lookup, from source to target.

        Raises UnknownFrameError, UnconnectedFramesError.
        """
        self._check(target, "chain argument target_frame")
        self._check(source, "chain argument source_frame")
        ancestor = self._common_ancestor(target, source)
        upward = list(self._frames_above(source, ancestor))
        downward = list(self._frames_above(target, ancestor))
        return [*upward, *reversed(downward[:-1])]

    @property
    def frames(self) -> list[str]:
        """The names of all frames, in the order of their first appearance."""
        return list(self._frames)

    @property
    def tree_text(self) -> str:
        """A line for each frame that has a parent, as in tf2."""
        return "".join(
            f"Frame {frame} exists with parent {self._caches[frame].latest.parent}.\n"
            for frame in self.children
        )

    @property
    def children(self) -> list[str]:
        """The names of the frames that have a parent, in the order of their first appearance."""
        return [frame for frame in self._frames if frame in self._caches]

    def cache_of(self, frame: str) -> TimeCache | StaticCache | None:
        """Return the stored transforms of a frame; None for one without a parent."""
        return self._caches.get(frame)

    def clear(self) -> None:
        """Remove all transforms, for instance after a jump back in time; the names of frames stay known."""
        self._caches.clear()

    def _check(self, frame: str, argument: str) -> None:
        if not frame:
            raise TransformError(f"Invalid argument passed to {argument} in tf2 frame_ids cannot be empty")
        if frame.startswith("/"):
            raise TransformError(
                f'Invalid argument "{frame}" passed to {argument} in tf2 frame_ids '
                "cannot start with a '/' like: "
            )
        if frame not in self._frames:
            raise UnknownFrameError(f'"{frame}" passed to {argument} does not exist. ')

    def _walk(self, target: str, source: str, time_ns: int) -> Transform:
        route = f", when looking up transform from frame [{source}] to frame [{target}]"
        from_source, frame = Transform(), source
        stopped: ExtrapolationError | None = None
        for _ in range(MAX_DEPTH):
            cache = self._caches.get(frame)
            if cache is None:
                break
            try:
                entry = cache.at(time_ns)
            except ExtrapolationError as error:
                # The path from the target may still reach this frame.
                stopped = error
                break
            if frame == target:
                return from_source
            from_source, frame = entry.transform @ from_source, entry.parent
        else:
            raise self._loop()
        top, from_target, frame = frame, Transform(), target
        for _ in range(MAX_DEPTH):
            if frame == top:
                return from_target.inverse() @ from_source
            cache = self._caches.get(frame)
            if cache is None:
                break
            try:
                entry = cache.at(time_ns)
            except ExtrapolationError as error:
                raise ExtrapolationError(f"{error}{route}") from None
            if frame == source:
                return from_target.inverse()
            from_target, frame = entry.transform @ from_target, entry.parent
        else:
            raise self._loop()
        if stopped is not None:
            raise ExtrapolationError(f"{stopped}{route}")
        raise _unconnected(target, source)

    def _common_ancestor(self, target: str, source: str) -> str:
        passed: dict[str, None] = {}
        for frame in self._frames_above(source):
            if frame == target:
                return target
            passed[frame] = None
        for frame in self._frames_above(target):
            if frame in passed:
                return frame
        raise _unconnected(target, source)

    def _frames_above(self, frame: str, last: str = "") -> Iterator[str]:
        for _ in range(MAX_DEPTH):
            yield frame
            cache = self._caches.get(frame)
            if cache is None or frame == last:
                return
            frame = cache.latest.parent
        raise self._loop()

    def _loop(self) -> UnknownFrameError:
        return UnknownFrameError(f"The tf tree is invalid because it contains a loop.\n{self.tree_text}\n")


def _unconnected(target: str, source: str) -> UnconnectedFramesError:
    return UnconnectedFramesError(
        f"Could not find a connection between '{target}' and '{source}' because they are not part of "
        "the same tree.Tf has two or more unconnected trees."
    )


def _defect(parent: str, child: str, transform: Transform, authority: str) -> str:
    if parent == child:
        return (
            f'TF_SELF_TRANSFORM: Ignoring transform from authority "{authority}" with frame_id and '
            f'child_frame_id  "{child}" because they are the same'
        )
    if not child:
        return (
            f'TF_NO_CHILD_FRAME_ID: Ignoring transform from authority "{authority}" '
            "because child_frame_id not set "
        )
    if not parent:
        return (
            f'TF_NO_FRAME_ID: Ignoring transform with child_frame_id "{child}"  from authority "{authority}" '
            "because frame_id not set"
        )
    if max(len(parent), len(child)) > MAX_FRAME_NAME_LENGTH:
        return f"TF_LONG_FRAME_ID: Ignoring a frame whose name is longer than {MAX_FRAME_NAME_LENGTH}"
    numbers = (*transform.translation, *transform.rotation)
    if any(map(math.isnan, numbers)):
        shown = "({:.6f} {:.6f} {:.6f}) ({:.6f} {:.6f} {:.6f} {:.6f})".format(*numbers)
        return (
            f'TF_NAN_INPUT: Ignoring transform for child_frame_id "{child}" from authority "{authority}" '
            f"because of a nan value in the transform {shown}"
        )
    if not has_unit_length(transform.rotation):
        shown = " ".join(f"{each:.6f}" for each in transform.rotation)
        return (
            f'TF_DENORMALIZED_QUATERNION: Ignoring transform for child_frame_id "{child}" from authority '
            f'"{authority}" because of an invalid quaternion in the transform ({shown})'
        )
    return ""
