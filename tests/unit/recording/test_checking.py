from __future__ import annotations

from pathlib import Path

from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.recording.bag.writer import BagWriter
from rostether.recording.checking import check
from rostether.recording.recorded import Connection


def test_a_fault_with_a_damaged_name_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "damaged.bag"
    writer = BagWriter(path)
    broken = MessageType("std_mata\n\tto", "0" * 32, "string data\n")
    writer.write(writer.add_connection(Connection("/t\x1b[2J", broken, "/node")), 10**18, [b"\0\0\0\0"])
    writer.close()
    faults = check(path, Registry(bundled=False)).faults
    assert faults
    assert all(fault.isprintable() for fault in faults), faults
