# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.values import Message

class Bool(Message):
    data: bool
    def __init__(self, *, data: bool = ...) -> None: ...

class Byte(Message):
    data: int
    def __init__(self, *, data: int = ...) -> None: ...

class ByteMultiArray(Message):
    layout: MultiArrayLayout
    data: list[int]
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: Sequence[int] = ...) -> None: ...

class Char(Message):
    data: int
    def __init__(self, *, data: int = ...) -> None: ...

class ColorRGBA(Message):
    r: float
    g: float
    b: float
    a: float
    def __init__(self, *, r: float = ..., g: float = ..., b: float = ..., a: float = ...) -> None: ...

class Duration(Message):
    data: rostime.Duration
    def __init__(self, *, data: rostime.Duration | float = ...) -> None: ...

class Empty(Message):
    def __init__(self) -> None: ...

class Float32(Message):
    data: float
    def __init__(self, *, data: float = ...) -> None: ...

class Float32MultiArray(Message):
    layout: MultiArrayLayout
    data: list[float]
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: Sequence[float] = ...) -> None: ...

class Float64(Message):
    data: float
    def __init__(self, *, data: float = ...) -> None: ...

class Float64MultiArray(Message):
    layout: MultiArrayLayout
    data: list[float]
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: Sequence[float] = ...) -> None: ...

class Header(Message):
    seq: int
    stamp: rostime.Time
    frame_id: str
    def __init__(self, *, seq: int = ..., stamp: rostime.Time | float | Literal["now"] = ..., frame_id: str = ...) -> None: ...

class Int16(Message):
    data: int
    def __init__(self, *, data: int = ...) -> None: ...

class Int16MultiArray(Message):
    layout: MultiArrayLayout
    data: list[int]
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: Sequence[int] = ...) -> None: ...

class Int32(Message):
    data: int
    def __init__(self, *, data: int = ...) -> None: ...

class Int32MultiArray(Message):
    layout: MultiArrayLayout
    data: list[int]
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: Sequence[int] = ...) -> None: ...

class Int64(Message):
    data: int
    def __init__(self, *, data: int = ...) -> None: ...

class Int64MultiArray(Message):
    layout: MultiArrayLayout
    data: list[int]
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: Sequence[int] = ...) -> None: ...

class Int8(Message):
    data: int
    def __init__(self, *, data: int = ...) -> None: ...

class Int8MultiArray(Message):
    layout: MultiArrayLayout
    data: list[int]
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: Sequence[int] = ...) -> None: ...

class MultiArrayDimension(Message):
    label: str
    size: int
    stride: int
    def __init__(self, *, label: str = ..., size: int = ..., stride: int = ...) -> None: ...

class MultiArrayLayout(Message):
    dim: list[MultiArrayDimension]
    data_offset: int
    def __init__(self, *, dim: Sequence[MultiArrayDimension | Mapping[str, Any]] = ..., data_offset: int = ...) -> None: ...

class String(Message):
    data: str
    def __init__(self, *, data: str = ...) -> None: ...

class Time(Message):
    data: rostime.Time
    def __init__(self, *, data: rostime.Time | float | Literal["now"] = ...) -> None: ...

class UInt16(Message):
    data: int
    def __init__(self, *, data: int = ...) -> None: ...

class UInt16MultiArray(Message):
    layout: MultiArrayLayout
    data: list[int]
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: Sequence[int] = ...) -> None: ...

class UInt32(Message):
    data: int
    def __init__(self, *, data: int = ...) -> None: ...

class UInt32MultiArray(Message):
    layout: MultiArrayLayout
    data: list[int]
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: Sequence[int] = ...) -> None: ...

class UInt64(Message):
    data: int
    def __init__(self, *, data: int = ...) -> None: ...

class UInt64MultiArray(Message):
    layout: MultiArrayLayout
    data: list[int]
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: Sequence[int] = ...) -> None: ...

class UInt8(Message):
    data: int
    def __init__(self, *, data: int = ...) -> None: ...

class UInt8MultiArray(Message):
    layout: MultiArrayLayout
    data: bytes
    def __init__(self, *, layout: MultiArrayLayout | Mapping[str, Any] = ..., data: bytes | Sequence[int] = ...) -> None: ...
