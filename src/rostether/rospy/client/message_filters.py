"""message_filters: combines messages of several topics by their stamps."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

from rostether.rospy.client.logs import loginfo, logwarn
from rostether.rospy.client.ros_time import Duration, Time, get_rostime, is_wallclock
from rostether.rospy.client.subscriber import Subscriber as _Subscriber

_NO_STAMP = (
    "Cannot use message filters with non-stamped messages. Use the 'allow_headerless' constructor option to "
    "auto-assign ROS time to headerless messages."
)


class SimpleFilter:
    """Passes messages to callbacks."""

    def __init__(self) -> None:
        self.callbacks: dict[int, tuple[Callable[..., object], tuple[Any, ...]]] = {}

    def registerCallback(self, cb: Callable[..., object], *args: Any) -> int:
        """Call `cb` with each output, followed by `args`; return the number of the callback."""
        number = len(self.callbacks)
        self.callbacks[number] = (cb, args)
        return number

    def signalMessage(self, *msg: Any) -> None:
        """Pass an output to the callbacks."""
        for callback, arguments in list(self.callbacks.values()):
            callback(*msg, *arguments)


class Subscriber(SimpleFilter):
    """A subscription as the source of filters, with the arguments of rospy.Subscriber."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__()
        self.topic = args[0]
        self.sub = _Subscriber(*args, **{**kwargs, "callback": self.signalMessage})

    def getTopic(self) -> str:
        """Return the topic as it was given."""
        return str(self.topic)

    def __getattr__(self, key: str) -> Any:
        if key == "sub":
            raise AttributeError(key)
        return getattr(self.sub, key)


class Cache(SimpleFilter):
    """Remembers the last `cache_size` messages of a filter."""

    def __init__(self, f: SimpleFilter, cache_size: int = 1, allow_headerless: bool = False) -> None:
        super().__init__()
        self.cache_size = cache_size
        self.cache_msgs: list[Any] = []
        self.cache_times: list[Any] = []
        self.allow_headerless = allow_headerless
        self.connectInput(f)

    def connectInput(self, f: SimpleFilter) -> None:
        """Connect the filter whose messages are remembered."""
        self.incoming_connection = f.registerCallback(self.add)

    def add(self, msg: Any) -> None:
        """Handle a message."""
        stamp = _stamp_of(msg, self.allow_headerless)
        if stamp is None:
            return
        self.cache_times = [*self.cache_times, stamp][-self.cache_size :]
        self.cache_msgs = [*self.cache_msgs, msg][-self.cache_size :]
        self.signalMessage(msg)

    def getInterval(self, from_stamp: Any, to_stamp: Any) -> list[Any]:
        """Return the messages of an interval, including both ends."""
        return [msg for msg, time in self._pairs() if from_stamp <= time <= to_stamp]

    def getElemAfterTime(self, stamp: Any) -> Any:
        """Return the first message at or after a time, or None."""
        return next((msg for msg, time in self._pairs() if time >= stamp), None)

    def getElemBeforeTime(self, stamp: Any) -> Any:
        """Return the last message at or before a time, or None."""
        return next((msg for msg, time in reversed(self._pairs()) if time <= stamp), None)

    def getLatestTime(self) -> Any:
        """Return the stamp of the last message, or None."""
        return self.cache_times[-1] if self.cache_times else None

    getLastestTime = getLatestTime  # the old, misspelled name

    def getOldestTime(self) -> Any:
        """Return the stamp of the oldest message, or None."""
        return self.cache_times[0] if self.cache_times else None

    def getLast(self) -> Any:
        """Return the last message, or None."""
        latest = self.getLatestTime()
        return None if latest is None else self.getElemAfterTime(latest)

    def _pairs(self) -> list[tuple[Any, Any]]:
        # Not strict: another thread may be adding a message.
        return list(zip(self.cache_msgs, self.cache_times, strict=False))


class TimeSynchronizer(SimpleFilter):
    """Passes on one message of each filter together if their stamps are equal.

    With `reset`, a jump of simulated time into the past clears the queues.
    """

    def __init__(self, fs: Sequence[SimpleFilter], queue_size: int, reset: bool = False) -> None:
        super().__init__()
        self.queue_size = queue_size
        self.enable_reset = reset
        self.last_added: Any = Time()
        self.lock = threading.Lock()
        self.connectInput(fs)

    def connectInput(self, fs: Sequence[SimpleFilter]) -> None:
        """Connect the filters whose messages are combined."""
        self.queues: list[dict[Any, Any]] = [{} for _ in fs]
        self.input_connections = [
            each.registerCallback(self.add, queue, index)
            for index, (each, queue) in enumerate(zip(fs, self.queues, strict=True))
        ]

    def add(self, msg: Any, my_queue: dict[Any, Any], my_queue_index: int | None = None) -> None:
        """Handle a message of one filter."""
        with self.lock:
            if self.enable_reset and not is_wallclock():
                self._clear_after_jump()
            self._keep(msg.header.stamp, msg, my_queue)
            for stamp in sorted(set.intersection(*(set(queue) for queue in self.queues))):
                self._pass_on([stamp] * len(self.queues))

    def _clear_after_jump(self) -> None:
        now = get_rostime()
        if now < self.last_added:
            loginfo("%s: Detected jump back in time. Clearing buffer.", type(self).__name__)
            for queue in self.queues:
                queue.clear()
        self.last_added = now

    def _keep(self, stamp: Any, msg: Any, queue: dict[Any, Any]) -> None:
        queue[stamp] = msg
        while len(queue) > self.queue_size:
            del queue[min(queue)]

    def _pass_on(self, stamps: Sequence[Any]) -> None:
        together = [queue.pop(stamp) for queue, stamp in zip(self.queues, stamps, strict=True)]
        self.signalMessage(*together)


class ApproximateTimeSynchronizer(TimeSynchronizer):
    """Passes on one message of each filter together if their stamps are within `slop` seconds.

    A jump of ROS time into the past always clears the queues.
    """

    def __init__(
        self,
        fs: Sequence[SimpleFilter],
        queue_size: int,
        slop: float,
        allow_headerless: bool = False,
        reset: bool = False,
    ) -> None:
        super().__init__(fs, queue_size, reset)
        self.slop = Duration.from_sec(slop)
        self.allow_headerless = allow_headerless

    def add(self, msg: Any, my_queue: dict[Any, Any], my_queue_index: int | None = None) -> None:
        """Handle a message of one filter."""
        stamp = _stamp_of(msg, self.allow_headerless)
        if stamp is None:
            return
        with self.lock:
            self._clear_after_jump()
            self._keep(stamp, msg, my_queue)
            near = [[stamp] if queue is my_queue else self._near(queue, stamp) for queue in self.queues]
            for stamps in product(*near):
                if max(stamps) - min(stamps) < self.slop and stamp in my_queue:
                    self._pass_on(stamps)
                    return

    def _near(self, queue: dict[Any, Any], stamp: Any) -> list[Any]:
        """Return the stamps in a queue that are within `slop`, the nearest first."""
        near = (each for each in queue if abs(each - stamp) <= self.slop)
        return sorted(near, key=lambda each: abs(each - stamp))


def _stamp_of(msg: Any, allow_headerless: bool) -> Any:
    stamp = getattr(getattr(msg, "header", None), "stamp", None)
    if stamp is None and allow_headerless:
        return get_rostime()
    if stamp is None:
        logwarn(_NO_STAMP)
    return stamp
