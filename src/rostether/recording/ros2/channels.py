"""The topics of a ROS 2 recording being written: their ROS 2 types, and their messages as CDR."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from msgspec import Struct

from rostether.errors import RecordingError, RostetherError, SerializationError
from rostether.msgdef.interface import ANY_MD5SUM
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definition_files import BUNDLED_DISTRO
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.recording.file_lock import ACTIVE_SUFFIX
from rostether.recording.recorded import Connection, Ros2Origin
from rostether.recording.ros2.metadata import FileFacts
from rostether.recording.ros2_qos import offered
from rostether.recording.ros2_types import ROS2MSG, RecordedDefinitions
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_hash import TYPE_HASH_NOT_SUPPORTED
from rostether.ros2.types.type_support import Ros2Types


class Ros2Channel(Struct):
    """One topic with one type in one file; `origin` is its description in the file."""

    number: int
    topic: str
    origin: Ros2Origin
    to_cdr: Callable[[bytes], bytes]
    message_count: int = 0


class Ros2Channels:
    """The channels of one file, in the order of their numbers from 1.

    As in rosbag2, all publishers of a topic share one channel, with the quality of service of the first
    publisher. `types` are the types of the recorded graph, else those of the environment. Messages that do
    not fit their type are omitted, and counted by `unfit`.
    """

    def __init__(self, types: Ros2Types | None, unfit: UnfitMessages | None) -> None:
        self.channels: list[Ros2Channel] = []
        self._unfit = unfit
        self._types = types
        self._by_connection: dict[Connection, Ros2Channel] = {}
        self._by_topic: dict[tuple[str, str, str], Ros2Channel] = {}

    def channel(self, connection: Connection) -> Ros2Channel:
        """Return a connection's channel. Raises RecordingError naming the topic."""
        channel = self._by_connection.get(connection)
        if channel is not None:
            return channel
        try:
            origin, to_cdr = self._describe(connection)
        except RostetherError as error:
            raise RecordingError(f"{connection.topic} cannot be written for ROS 2: {error}") from None
        key = (connection.topic, origin.type_name, origin.type_hash)
        channel = self._by_topic.get(key)
        if channel is None:
            channel = Ros2Channel(len(self.channels) + 1, connection.topic, origin, to_cdr)
            self.channels.append(channel)
            self._by_topic[key] = channel
        self._by_connection[connection] = channel
        return channel

    def converted(self, channel: Ros2Channel, payloads: Sequence[bytes]) -> list[bytes]:
        """Return messages as CDR, counted; those that do not fit their type are omitted."""
        try:
            converted = list(map(channel.to_cdr, payloads))
        except SerializationError:
            converted = []
            for payload in payloads:
                try:
                    converted.append(channel.to_cdr(payload))
                except SerializationError as error:
                    if self._unfit is not None:
                        self._unfit.add(channel.topic, str(error))
        channel.message_count += len(converted)
        return converted

    def facts(self, path: Path, counts: Mapping[int, int], span_ns: tuple[int, int] | None) -> FileFacts:
        """Return the contents of the file for metadata.yaml; `counts` has the messages by channel number."""
        topics = {
            (each.topic, each.origin.type_name): (each.origin, counts.get(each.number, 0))
            for each in self.channels
        }
        start_ns, end_ns = span_ns or (None, 0)
        return FileFacts(path.name.removesuffix(ACTIVE_SUFFIX), start_ns, end_ns, topics)

    def _describe(self, connection: Connection) -> tuple[Ros2Origin, Callable[[bytes], bytes]]:
        if connection.origin is not None:
            definitions = RecordedDefinitions()
            definitions.learn(connection.origin)
            types: Ros2Types = NativeTypes(NativeRegistry(definitions, Registry.from_environment()))
        else:
            types = self._own_types()
        support = types.message(connection.type)
        type_hash = "" if support.type_hash == TYPE_HASH_NOT_SUPPORTED else support.type_hash
        if connection.origin is not None and connection.origin.type_name == support.name:
            origin = connection.origin
            if origin.definition and origin.type_hash:
                return origin, support.converter.to_cdr
            qos = origin.qos
        else:
            qos = offered(is_latching=connection.is_latching, is_best_effort=connection.is_best_effort)
        text = types.full_text(connection.type)
        # rosbag2 also writes "unknown" for a type without a definition.
        encoding = ROS2MSG if text or connection.type.md5sum != ANY_MD5SUM else "unknown"
        return Ros2Origin(support.name, type_hash, encoding, text, qos), support.converter.to_cdr

    def _own_types(self) -> Ros2Types:
        if self._types is None:
            registry = Registry.from_environment()
            self._types = NativeTypes(NativeRegistry(Ros2Definitions.from_environment(), registry))
        return self._types


def distro_of(types: Ros2Types | None) -> str:
    """Return the ROS 2 distribution to name in a recording of a graph with these types."""
    return BUNDLED_DISTRO if types is None else types.definitions.distro


class UnfitMessages:
    """Counts omitted messages by topic, over all files; `report` receives one line for each topic."""

    def __init__(self, report: Callable[[str], None]) -> None:
        self.counts: dict[str, int] = {}
        self._report = report

    def add(self, topic: str, why: str) -> None:
        """Count a message of a topic that does not fit its type, and why."""
        if topic not in self.counts:
            self._report(f"WARNING: {topic}: messages that do not fit their type are skipped: {why}")
        self.counts[topic] = self.counts.get(topic, 0) + 1
