"""Runs every benchmark and prints a table: the result, the goal, and the bare relay of the same run.

python -m benchmarks [throughput|round-trip|footprint|crowd|scale|flooding|frames|codec|cdr|cycles|flash|
    memory|gateways|zenoh ...]
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from rich.console import Console
from rich.table import Table

from benchmarks import (
    cdr_conversion,
    crowd,
    flooding_boards,
    footprint,
    gateways,
    recording,
    rosserial_frames,
    round_trip,
    scale,
    serde_codec,
    sizes,
    throughput,
)
from firmware.examples import counting as cycles
from firmware.examples import established


def throughput_table() -> Table:
    """Measure floods in both directions."""
    table = Table(
        "flood", "messages/s", "lost", "CPU s/100k", "bare relay/s", "ratio", "wanted", title="Throughput"
    )
    for type_name, count, wanted in (
        ("std_msgs/String", 600_000, "150,000 and 60 %"),
        ("sensor_msgs/Imu", 300_000, "100,000"),
        ("sensor_msgs/CompressedImage", 60_000, "10,000"),
    ):
        relay = throughput.relay_to_ros(type_name, count)
        flood = throughput.device_to_ros(type_name, count)
        _row(table, f"device to ROS, {throughput.SIZES[type_name]} B", flood, relay, wanted)
    _row(
        table,
        "ROS to device, 64 B",
        throughput.ros_to_device(600_000),
        throughput.relay_from_ros(600_000),
        "150,000",
    )
    return table


def _row(table: Table, name: str, flood: throughput.Flood, relay: throughput.Flood, wanted: str) -> None:
    table.add_row(
        name,
        f"{flood.rate_hz:,.0f}",
        f"{flood.sent - flood.received:,}",
        f"{flood.cpu_per_100k_s:.2f}",
        f"{relay.rate_hz:,.0f}",
        f"{flood.rate_hz / relay.rate_hz:.0%}",
        wanted,
    )


def round_trip_table() -> Table:
    """Measure round trips at two rates."""
    table = Table("round trip ROS, device, ROS", "p50 ms", "p99 ms", "lost", "wanted", title="Round trip")
    for rate_hz, wanted in ((100, "p50 0.4, p99 2"), (1000, "p50 0.4")):
        trips = round_trip.round_trips(rate_hz, 5 * rate_hz)
        table.add_row(
            f"{rate_hz} Hz",
            f"{trips.percentile_ms(50):.2f}",
            f"{trips.percentile_ms(99):.2f}",
            str(trips.sent - len(trips.times_s)),
            wanted,
        )
    return table


def footprint_table() -> Table:
    """Measure start, idle CPU and memory."""
    table = Table("footprint", "measured", "wanted", title="Footprint")
    starts = sorted(footprint.start_to_first_message_s() for _ in range(5))
    table.add_row("start to first message", f"{starts[2]:.2f} s", "0.4 s and roscpp's own 0.2 s")
    for devices, memory in ((1, "0.5 %, 45 MB"), (32, "70 MB")):
        cost = footprint.idle(devices)
        table.add_row(f"{devices} device(s)", f"{cost.cpu_percent:.1f} %, {cost.resident_mb:.0f} MB", memory)
    return table


def crowd_table() -> Table:
    """Measure a hundred devices, alone and beside one that floods."""
    table = Table(
        "100 devices at 50 Hz",
        "lost",
        "p50 ms",
        "p99 ms",
        "longest",
        "sent late",
        "CPU",
        "MB",
        "wanted",
        title="Crowd",
        caption="sent late: the delay of the devices' own program, p99 and longest, in ms",
    )
    for name, floods, trouble in (
        ("alone", False, ""),
        ("beside a flood", True, ""),
        ("beside 10 MB/s of random bytes", False, "noise"),
        ("beside 10 MB/s of headers without ends", False, "headers"),
        ("beside announcements that always change, rosmaster", False, "announcements"),
    ):
        seen = crowd.crowd(100, 50, 10, floods=floods, trouble=trouble, roscore=trouble == "announcements")
        table.add_row(
            name,
            f"{seen.sent - seen.received:,} of {seen.sent:,}",
            f"{seen.p50_ms:.2f}",
            f"{seen.p99_ms:.2f}",
            f"{seen.longest_ms:.1f}",
            f"{seen.late_p99_ms:.1f}, {seen.late_longest_ms:.0f}",
            f"{seen.cpu_percent:.0f} %",
            f"{seen.resident_mb:.0f}",
            "0, p99 10 ms, 120 MB",
        )
    return table


def scale_table() -> Table:
    """Measure increasing numbers of boards."""
    columns = "boards", "lost", "p50 ms", "p99 ms", "longest", "sent late, p99", "CPU", "MB", "wanted"
    table = Table(*columns, title=f"Scale, {scale.RATE_HZ} Hz each")
    for devices, seen in scale.scales():
        table.add_row(
            f"{devices:,}",
            f"{seen.sent - seen.received:,} of {seen.sent:,}",
            f"{seen.p50_ms:.2f}",
            f"{seen.p99_ms:.2f}",
            f"{seen.longest_ms:.1f}",
            f"{seen.late_p99_ms:.1f}",
            f"{seen.cpu_percent:.0f} %",
            f"{seen.resident_mb:.0f}",
            "0, p99 10 ms",
        )
    return table


def flooding_table() -> Table:
    """Measure boards that all flood one roscpp subscriber, in ten rounds each."""
    rounds = 10
    columns = "boards", "lost in each round", "messages a round", "messages/s", "wanted"
    table = Table(*columns, title="Flooding boards, 64 B, one roscpp subscriber")
    for boards in (1, 8, 32):
        found = [flooding_boards.flooding_boards(boards, 200_000) for _ in range(rounds)]
        rates = sorted(each.received / each.seconds for each in found)
        table.add_row(
            str(boards),
            " ".join(str(each.lost) for each in found),
            f"{found[0].sent:,}",
            f"{rates[rounds // 2]:,.0f}",
            "0 lost",
        )
    return table


def frames_table() -> Table:
    """Measure the frame loop alone."""
    table = Table("frame loop", "a second", "wanted", title="Frames")
    for row in rosserial_frames.measure():
        table.add_row(row.operation, f"{row.rate_hz:,.0f}", f"{row.wanted_hz:,.0f}" if row.wanted_hz else "")
    return table


def codec_table() -> Table:
    """Measure values to bytes and back, compared with rosbags."""
    return _beside_rosbags("Codec", serde_codec.compare())


def cdr_table() -> Table:
    """Measure ROS 1 serialization to CDR and back, compared with rosbags."""
    table = _beside_rosbags("CDR", cdr_conversion.compare())
    table.caption = "wanted: a String at most 1,500 ns, an Imu at most 3,000 ns"
    return table


def _beside_rosbags(title: str, rows: list[serde_codec.Row]) -> Table:
    table = Table("operation", "rostether ns", "rosbags ns", "ratio", title=title)
    for row in rows:
        rosbags = "" if row.rosbags_ns is None else f"{row.rosbags_ns:,.0f}"
        ratio = "" if row.rosbags_ns is None else f"{row.rosbags_ns / row.rostether_ns:.1f}"
        table.add_row(row.operation, f"{row.rostether_ns:,.0f}", rosbags, ratio)
    return table


def cycles_table() -> Table:
    """Count the cycles that the client library uses on a Mega."""
    title = "Client library, cycles on a Mega"
    table = Table(
        "operation", "rostether", "relative", "with Serial, 1 Mbaud", "established", "wanted", title=title
    )
    neutral, serial = cycles.count(neutral=True), cycles.count(neutral=False)
    for operation in cycles.OPERATIONS:
        table.add_row(
            operation.name,
            f"{neutral[operation]:,}",
            "" if not operation.established else f"{neutral[operation] / operation.established:.0%}",
            f"{serial[operation]:,}",
            "" if not operation.established else f"{operation.established:,}",
            "" if not operation.established else f"{operation.max_part:.0%}",
        )
    return table


def flash_table() -> Table:
    """Measure how much flash of two boards the examples use."""
    columns = "board", "example", "flash B", "relative", "without Wire and USB"
    table = Table(*columns, title="Client library, flash")
    for board in established.ESTABLISHED:
        measured = sizes.measure_flash(board)
        for size in measured:
            table.add_row(board, size.example, f"{size.bytes:,}", f"{size.part:.1%}", f"{size.ros_part:.1%}")
        table.add_row(board, "median", "", "", f"{established.median_part(measured):.1%}", end_section=True)
    table.caption = "wanted: a median of 60 %, each at most 66 %"
    return table


def memory_table() -> Table:
    """Measure how much of an Uno's RAM the examples use."""
    columns = "example", "RAM B", "stack B", "RAM + stack", "relative"
    table = Table(*columns, title="Client library, RAM of an Uno")
    for size in sizes.measure_ram():
        table.add_row(
            size.example,
            f"{size.static_bytes:,}",
            f"{size.stack_bytes:,}",
            f"{size.static_bytes + size.stack_bytes:,}",
            f"{size.part():.1%}",
        )
    table.caption = "wanted: at most 50 %; the stack is the deepest in 3 s"
    return table


def gateways_table() -> Table:
    """Measure gateways whose clients receive many topics."""
    title = f"Gateways, {gateways.TOPICS} topics at {gateways.RATE_HZ:.0f} Hz"
    table = Table("gateway", "CPU", "received", "sent", "wanted", title=title)
    costs = gateways.gateway_costs()
    for name, kind, wanted in (
        ("Foxglove", "foxglove", "less than rosbridge"),
        ("rosbridge, JSON", "json", ""),
        ("rosbridge, cbor-raw", "cbor-raw", ""),
    ):
        cost = costs[kind]
        table.add_row(name, f"{cost.cpu_percent:.0f} %", f"{cost.received:,}", f"{cost.expected:,}", wanted)
    return table


def recording_table() -> Table:
    """Measure the recording and the playback of a flood, compared with Debian's rosbag."""
    table = Table("bag", "messages/s", "lost", "cores", "wanted", title="Recording, 64 B")
    for kept in recording.recordings():
        table.add_row(
            f"record: {kept.name}",
            f"{kept.sent_hz:,.0f}",
            f"{kept.lost:,} of {kept.sent:,}",
            f"{kept.cores:.2f}",
            "0 lost, 1 core" if kept.name in ("rostether, .bag", "rostether, .mcap") else "",
        )
    for each in recording.playbacks():
        table.add_row(f"play: {each.name}", f"{each.rate_hz:,.0f}", f"{each.lost:,}", f"{each.cores:.2f}", "")
    return table


def zenoh_table() -> Table:
    """Measure the bridge into ROS 2 over zenoh: floods out of it, and round trips."""
    from benchmarks import zenoh_flows, zenoh_line  # The extra may be missing.

    table = Table("ROS 2 over zenoh", "measured", "lost", "CPU s/100k", "wanted", title="ROS 2 over zenoh")
    for type_name, count, wanted in (
        ("std_msgs/String", 600_000, "80,000"),
        ("sensor_msgs/Imu", 300_000, "40,000"),
        ("sensor_msgs/CompressedImage", 60_000, ""),
    ):
        flood = zenoh_flows.device_to_ros2(type_name, count)
        table.add_row(
            f"device to zenoh subscriber, {throughput.SIZES[type_name]} B",
            f"{flood.rate_hz:,.0f}/s",
            f"{flood.sent - flood.received:,}",
            f"{flood.cpu_per_100k_s:.2f}",
            wanted and f"{wanted}/s",
        )
    for rate_hz in (100, 1000):
        trips = zenoh_flows.round_trips(rate_hz, 5 * rate_hz)
        table.add_row(
            f"round trip zenoh, device, zenoh, {rate_hz} Hz",
            f"p50 {trips.percentile_ms(50):.2f} ms, p99 {trips.percentile_ms(99):.2f} ms",
            str(trips.sent - len(trips.times_s)),
            "",
            "p50 1 ms",
        )
    bare = zenoh_flows.bare_round_trips(100, 500)
    table.add_row(
        "the same without the library, 100 Hz",
        f"p50 {bare.percentile_ms(50):.2f} ms, p99 {bare.percentile_ms(99):.2f} ms",
        str(bare.sent - len(bare.times_s)),
        "",
        "",
    )
    for payload_bytes in (8, 64):
        trips = zenoh_line.round_trips(payload_bytes, 300)
        table.add_row(
            f"round trip zenoh, Uno at 115200 baud, zenoh, {payload_bytes} B",
            f"p50 {trips.percentile_ms(50):.2f} ms, p99 {trips.percentile_ms(99):.2f} ms",
            str(trips.sent - len(trips.times_s)),
            "",
            f"the line: {zenoh_line.line_ms(payload_bytes):.2f} ms",
        )
    return table


TABLES = {
    "throughput": throughput_table,
    "round-trip": round_trip_table,
    "footprint": footprint_table,
    "crowd": crowd_table,
    "scale": scale_table,
    "flooding": flooding_table,
    "frames": frames_table,
    "codec": codec_table,
    "cdr": cdr_table,
    "cycles": cycles_table,
    "flash": flash_table,
    "memory": memory_table,
    "gateways": gateways_table,
    "recording": recording_table,
    "zenoh": zenoh_table,
}


def main(names: list[str]) -> None:
    """Print the tables that the arguments name; without arguments, all."""
    if unknown := [name for name in names if name not in TABLES]:
        sys.exit(f"no benchmark is named {unknown[0]}; the names are {', '.join(TABLES)}")
    console = Console()
    for name in names or TABLES:
        console.print(TABLES[name]())


if __name__ == "__main__":
    main(sys.argv[1:])
