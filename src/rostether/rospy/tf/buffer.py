"""tf2_ros.Buffer: our tf buffer with ROS messages and times, safe to use from any thread."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rostether.errors import ExtrapolationError, TransformError, UnconnectedFramesError, UnknownFrameError
from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.tf_cache import DEFAULT_CACHE_NS
from rostether.robot.transform import StampedTransform, transform_of
from rostether.rospy.client.ros_time import Duration, Time, get_rostime, sleep
from rostether.rospy.tf.buffer_interface import NO_TIME, BufferInterface
from rostether.rospy.tf.exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformException,
)
from rostether.rospy.tf.geometry import transform_message

# The interval between two checks, as a part of the timeout, as in tf2_ros.
POLLING_SCALE = 0.01


class Buffer(BufferInterface):
    """Keeps the transforms of the last ten seconds, or of `cache_time`."""

    def __init__(self, cache_time: Any = None, debug: bool = True) -> None:
        super().__init__()
        cache_ns = DEFAULT_CACHE_NS if cache_time is None else cache_time.to_nsec()
        self._buffer = TransformBuffer(cache_ns)
        self._lock = threading.RLock()

    def set_transform(self, transform: Any, authority: str = "default_authority") -> None:
        """Store a TransformStamped."""
        self._set(transform, authority, is_static=False)

    def set_transform_static(self, transform: Any, authority: str = "default_authority") -> None:
        """Store a TransformStamped that is valid at all times."""
        self._set(transform, authority, is_static=True)

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any = NO_TIME
    ) -> Any:
        """Return a TransformStamped; wait for it at most `timeout`.

        Raises LookupException, ConnectivityException, ExtrapolationException, InvalidArgumentException.
        """
        self.can_transform(target_frame, source_frame, time, timeout)
        return self.lookup_transform_core(target_frame, source_frame, time)

    def lookup_transform_core(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """Return the result of `lookup_transform`, without waiting. Raises the same errors."""
        with self._lock, _tf2_errors():
            return _to_message(self._buffer.lookup(target_frame, source_frame, time.to_nsec()))

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = NO_TIME,
    ) -> Any:
        """Return the pose of the source at one time in the target at another.

        Raises the same exceptions as `lookup_transform`.
        """
        route = (target_frame, target_time, source_frame, source_time, fixed_frame)
        self.can_transform_full(*route, timeout)
        return self.lookup_transform_full_core(*route)

    def lookup_transform_full_core(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> Any:
        """Return the result of `lookup_transform_full`, without waiting. Raises the same exceptions."""
        with self._lock, _tf2_errors():
            return _to_message(
                self._buffer.lookup_through(
                    target_frame, target_time.to_nsec(), source_frame, source_time.to_nsec(), fixed_frame
                )
            )

    def can_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Any,
        timeout: Any = NO_TIME,
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether a lookup would succeed within `timeout`.

        With `return_debug_tuple`, returns a pair with the reason why it would not.
        """
        result = _wait(lambda: self.can_transform_core(target_frame, source_frame, time), timeout)
        return result if return_debug_tuple else result[0]

    def can_transform_core(self, target_frame: str, source_frame: str, time: Any) -> tuple[bool, str]:
        """Return whether a lookup would succeed now, and the reason why it would not."""
        with self._lock:
            reason = self._buffer.lookup_error(target_frame, source_frame, time.to_nsec())
        return not reason, reason

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = NO_TIME,
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether a lookup with two times would succeed within `timeout`, like `can_transform`."""
        route = (target_frame, target_time, source_frame, source_time, fixed_frame)
        result = _wait(lambda: self._can_look_up_full(*route), timeout)
        return result if return_debug_tuple else result[0]

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Time:
        """Return the latest time at which a lookup succeeds; zero if all transforms are static.

        Raises LookupException, ConnectivityException, InvalidArgumentException.
        """
        with self._lock, _tf2_errors():
            return Time(0, self._buffer.latest_common_time_ns(target_frame, source_frame))

    def all_frames_as_string(self) -> str:
        """Return a line for each frame that has a parent."""
        with self._lock:
            return self._buffer.tree_text

    def all_frames_as_yaml(self) -> str:
        """Return the frames with their parents as YAML."""
        import yaml

        with self._lock:
            frames = {
                frame: {"parent": cache.latest.parent, "most_recent_transform": cache.latest_ns / 1e9}
                for frame in self._buffer.children
                if (cache := self._buffer.cache_of(frame)) is not None
            }
        return str(yaml.safe_dump(frames)) if frames else "[]"

    def frame_names(self) -> list[str]:
        """Return the names of the frames that have a parent."""
        with self._lock:
            return self._buffer.children

    def clear(self) -> None:
        """Remove all transforms."""
        with self._lock:
            self._buffer.clear()

    def _can_look_up_full(self, *route: Any) -> tuple[bool, str]:
        try:
            self.lookup_transform_full_core(*route)
        except TransformException as error:
            return False, str(error)
        return True, ""

    def _set(self, transform: Any, authority: str, *, is_static: bool) -> None:
        stamped = StampedTransform(
            transform.header.frame_id,
            transform.child_frame_id,
            transform.header.stamp.to_nsec(),
            transform_of(transform),
        )
        with self._lock:
            self._buffer.set_transform(stamped, authority=authority, is_static=is_static)


@contextmanager
def _tf2_errors() -> Iterator[None]:
    try:
        yield
    except UnknownFrameError as error:
        raise LookupException(f"{error}") from None
    except UnconnectedFramesError as error:
        raise ConnectivityException(f"{error}") from None
    except ExtrapolationError as error:
        raise ExtrapolationException(f"{error}") from None
    except TransformError as error:
        raise InvalidArgumentException(f"{error}") from None


def _wait(can: Callable[[], tuple[bool, str]], timeout: Any) -> tuple[bool, str]:
    result = can()
    if not result[0] and timeout.to_nsec() > 0:
        start = get_rostime()
        # After a large jump back in time, as when a bag starts again, the wait ends.
        while not result[0] and start - Duration(3) <= get_rostime() < start + timeout:
            sleep(timeout * POLLING_SCALE)
            result = can()
    return result


def _to_message(stamped: StampedTransform) -> Any:
    moved = stamped.transform
    stamp = Time(0, stamped.stamp_ns)
    return transform_message(stamped.parent, stamped.child, stamp, moved.translation, moved.rotation)
