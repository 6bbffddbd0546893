// The data of a plot as an MCAP file: each series is a topic with std_msgs/Float64, as in a recording of ROS 1 or 2.
// Source: https://mcap.dev/spec. The records are neither compressed nor indexed; readers then scan the file.
import type { Series } from "../../plot/series.ts";

const MAGIC = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
const HEADER = 0x01;
const FOOTER = 0x02;
const SCHEMA = 0x03;
const CHANNEL = 0x04;
const MESSAGE = 0x05;
const DATA_END = 0x0f;
const SCHEMA_ID = 1;
const RECORD_HEAD_BYTES = 9;
// Channel, sequence number and two times, before the payload.
const MESSAGE_HEAD_BYTES = 2 + 4 + 8 + 8;
const NUMBER_BYTES = 8;
const ROS1 = {
  profile: "ros1",
  encoding: "ros1",
  schemaEncoding: "ros1msg",
  type: "std_msgs/Float64",
  head: [],
};
// CDR begins with four bytes: little endian, no options.
const ROS2 = {
  profile: "ros2",
  encoding: "cdr",
  schemaEncoding: "ros2msg",
  type: "std_msgs/msg/Float64",
  head: [0, 1, 0, 0],
};
type Format = typeof ROS1 | typeof ROS2;
const utf8 = new TextEncoder();

interface Point {
  channel: number;
  timeS: number;
  value: number;
}

/** Returns the bytes of a file with the values between two times, in seconds since 1970. */
export function toMcap(series: readonly Series[], fromS: number, toS: number, isRos2: boolean): BlobPart[] {
  const format = isRos2 ? ROS2 : ROS1;
  const points = series.flatMap((each, index) => pointsOf(each, index + 1, fromS, toS));
  points.sort((a, b) => a.timeS - b.timeS);
  const schema = record(
    SCHEMA,
    u16(SCHEMA_ID),
    text(format.type),
    text(format.schemaEncoding),
    text("float64 data"),
  );
  const channels = series.map((each, index) =>
    record(
      CHANNEL,
      u16(index + 1),
      u16(SCHEMA_ID),
      text(topicOf(each.id)),
      text(format.encoding),
      map("unit", each.unit),
    ),
  );
  return [
    new Uint8Array(MAGIC),
    record(HEADER, text(format.profile), text("rostether")),
    schema,
    ...channels,
    messages(points, format),
    // No checksums, no summary.
    record(DATA_END, new Uint8Array(4)),
    record(FOOTER, new Uint8Array(20)),
    new Uint8Array(MAGIC),
  ];
}

/** A topic for the path of a series: `/imu.data[0].x` is `/imu/data_0/x`. */
export function topicOf(id: string): string {
  return id
    .replaceAll(".", "/")
    .replaceAll(/\[([^\]]*)\]/g, "_$1")
    .replaceAll(/[^A-Za-z0-9_/]/g, "_");
}

function pointsOf({ buffer }: Series, channel: number, fromS: number, toS: number): Point[] {
  const points: Point[] = [];
  for (let index = buffer.indexAt(fromS); index < buffer.length && buffer.time(index) <= toS; index++) {
    const value = buffer.value(index);
    // A gap has the time of the value before it.
    if (!Number.isNaN(value)) points.push({ channel, timeS: buffer.time(index), value });
  }
  return points;
}

function messages(points: readonly Point[], { head }: Format): Uint8Array<ArrayBuffer> {
  const messageBytes = MESSAGE_HEAD_BYTES + head.length + NUMBER_BYTES;
  const size = RECORD_HEAD_BYTES + messageBytes;
  const bytes = new Uint8Array(points.length * size);
  const view = new DataView(bytes.buffer);
  points.forEach(({ channel, timeS, value }, index) => {
    const start = index * size;
    const timeNs = BigInt(Math.round(timeS * 1e6)) * 1000n;
    view.setUint8(start, MESSAGE);
    view.setBigUint64(start + 1, BigInt(messageBytes), true);
    view.setUint16(start + RECORD_HEAD_BYTES, channel, true);
    view.setBigUint64(start + RECORD_HEAD_BYTES + 6, timeNs, true);
    view.setBigUint64(start + RECORD_HEAD_BYTES + 14, timeNs, true);
    bytes.set(head, start + RECORD_HEAD_BYTES + MESSAGE_HEAD_BYTES);
    view.setFloat64(start + size - NUMBER_BYTES, value, true);
  });
  return bytes;
}

function record(kind: number, ...parts: Uint8Array[]): Uint8Array<ArrayBuffer> {
  const length = parts.reduce((sum, each) => sum + each.length, 0);
  const bytes = new Uint8Array(RECORD_HEAD_BYTES + length);
  const view = new DataView(bytes.buffer);
  view.setUint8(0, kind);
  view.setBigUint64(1, BigInt(length), true);
  let at = RECORD_HEAD_BYTES;
  for (const each of parts) {
    bytes.set(each, at);
    at += each.length;
  }
  return bytes;
}

function u16(value: number): Uint8Array {
  return new Uint8Array([value & 0xff, value >> 8]);
}

function text(value: string): Uint8Array {
  return prefixed(utf8.encode(value));
}

/** A map with one entry, none without a value. */
function map(key: string, value: string): Uint8Array {
  if (!value) return prefixed(new Uint8Array(0));
  const [first, second] = [text(key), text(value)];
  const entries = new Uint8Array(first.length + second.length);
  entries.set(first);
  entries.set(second, first.length);
  return prefixed(entries);
}

function prefixed(content: Uint8Array): Uint8Array {
  const bytes = new Uint8Array(4 + content.length);
  new DataView(bytes.buffer).setUint32(0, content.length, true);
  bytes.set(content, 4);
  return bytes;
}
