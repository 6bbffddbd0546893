# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import std_msgs
from rostether.serde.values import Message

class Clock(Message):
    clock: rostime.Time
    def __init__(self, *, clock: rostime.Time | float | Literal["now"] = ...) -> None: ...

class Log(Message):
    DEBUG: int
    INFO: int
    WARN: int
    ERROR: int
    FATAL: int
    header: std_msgs.Header
    level: int
    name: str
    msg: str
    file: str
    function: str
    line: int
    topics: list[str]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., level: int = ..., name: str = ..., msg: str = ..., file: str = ..., function: str = ..., line: int = ..., topics: Sequence[str] = ...) -> None: ...

class TopicStatistics(Message):
    topic: str
    node_pub: str
    node_sub: str
    window_start: rostime.Time
    window_stop: rostime.Time
    delivered_msgs: int
    dropped_msgs: int
    traffic: int
    period_mean: rostime.Duration
    period_stddev: rostime.Duration
    period_max: rostime.Duration
    stamp_age_mean: rostime.Duration
    stamp_age_stddev: rostime.Duration
    stamp_age_max: rostime.Duration
    def __init__(self, *, topic: str = ..., node_pub: str = ..., node_sub: str = ..., window_start: rostime.Time | float | Literal["now"] = ..., window_stop: rostime.Time | float | Literal["now"] = ..., delivered_msgs: int = ..., dropped_msgs: int = ..., traffic: int = ..., period_mean: rostime.Duration | float = ..., period_stddev: rostime.Duration | float = ..., period_max: rostime.Duration | float = ..., stamp_age_mean: rostime.Duration | float = ..., stamp_age_stddev: rostime.Duration | float = ..., stamp_age_max: rostime.Duration | float = ...) -> None: ...
