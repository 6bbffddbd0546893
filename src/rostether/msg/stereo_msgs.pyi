# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import sensor_msgs, std_msgs
from rostether.serde.values import Message

class DisparityImage(Message):
    header: std_msgs.Header
    image: sensor_msgs.Image
    f: float
    T: float
    valid_window: sensor_msgs.RegionOfInterest
    min_disparity: float
    max_disparity: float
    delta_d: float
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., image: sensor_msgs.Image | Mapping[str, Any] = ..., f: float = ..., T: float = ..., valid_window: sensor_msgs.RegionOfInterest | Mapping[str, Any] = ..., min_disparity: float = ..., max_disparity: float = ..., delta_d: float = ...) -> None: ...
