// The data of a plot as an MCAP file: each series is a topic with std_msgs/Float64, as in a recording of ROS 1 or 2.
// Source: https://mcap.dev/spec. The file has one chunk, without compression, and its index.
import type { Series } from "../../plot/series.ts";

const MAGIC = new Uint8Array([0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a]);
const HEADER = 0x01;
const FOOTER = 0x02;
const SCHEMA = 0x03;
const CHANNEL = 0x04;
const MESSAGE = 0x05;
const CHUNK = 0x06;
const MESSAGE_INDEX = 0x07;
const CHUNK_INDEX = 0x08;
const STATISTICS = 0x0b;
const DATA_END = 0x0f;
const NO_CHECKSUM = new Uint8Array(4);
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
  const definitions = joined(
    record(SCHEMA, u16(SCHEMA_ID), text(format.type), text(format.schemaEncoding), text("float64 data")),
    ...series.map((each, index) =>
      record(
        CHANNEL,
        u16(index + 1),
        u16(SCHEMA_ID),
        text(topicOf(each.id)),
        text(format.encoding),
        map("unit", each.unit),
      ),
    ),
  );
  const content = joined(definitions, messages(points, format));
  const span = joined(u64(nanoseconds(points[0]?.timeS ?? 0)), u64(nanoseconds(points.at(-1)?.timeS ?? 0)));
  const size = u64(content.length);
  const head = joined(MAGIC, record(HEADER, text(format.profile), text("rostether")));
  const chunk = record(CHUNK, span, size, NO_CHECKSUM, text(""), size, content);

  const indexes = series.map(() => [] as Uint8Array[]);
  points.forEach(({ channel, timeS }, index) => {
    const start = definitions.length + index * messageBytes(format);
    indexes[channel - 1]!.push(u64(nanoseconds(timeS)), u64(start));
  });
  const indexRecords = indexes.map((each, index) =>
    record(MESSAGE_INDEX, u16(index + 1), prefixed(joined(...each))),
  );
  let at = head.length + chunk.length;
  const starts = indexRecords.map((each, index) => {
    at += each.length;
    return joined(u16(index + 1), u64(at - each.length));
  });
  const data = joined(head, chunk, ...indexRecords, record(DATA_END, NO_CHECKSUM));

  const counts = indexes.map((each, index) => joined(u16(index + 1), u64(each.length / 2)));
  const summary = [
    definitions,
    record(
      STATISTICS,
      u64(points.length),
      u16(1),
      u32(series.length),
      // No attachments, no metadata, one chunk.
      u64(0),
      u32(1),
      span,
      prefixed(joined(...counts)),
    ),
    record(
      CHUNK_INDEX,
      span,
      u64(head.length),
      u64(chunk.length),
      prefixed(joined(...starts)),
      u64(at - head.length - chunk.length),
      text(""),
      size,
      size,
    ),
  ];
  return [data, ...summary, record(FOOTER, u64(data.length), u64(0), NO_CHECKSUM), MAGIC];
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

function messageBytes({ head }: Format): number {
  return RECORD_HEAD_BYTES + MESSAGE_HEAD_BYTES + head.length + NUMBER_BYTES;
}

function nanoseconds(timeS: number): bigint {
  return BigInt(Math.round(timeS * 1e6)) * 1000n;
}

function messages(points: readonly Point[], format: Format): Uint8Array<ArrayBuffer> {
  const size = messageBytes(format);
  const bytes = new Uint8Array(points.length * size);
  const view = new DataView(bytes.buffer);
  points.forEach(({ channel, timeS, value }, index) => {
    const start = index * size;
    const timeNs = nanoseconds(timeS);
    view.setUint8(start, MESSAGE);
    view.setBigUint64(start + 1, BigInt(size - RECORD_HEAD_BYTES), true);
    view.setUint16(start + RECORD_HEAD_BYTES, channel, true);
    view.setBigUint64(start + RECORD_HEAD_BYTES + 6, timeNs, true);
    view.setBigUint64(start + RECORD_HEAD_BYTES + 14, timeNs, true);
    bytes.set(format.head, start + RECORD_HEAD_BYTES + MESSAGE_HEAD_BYTES);
    view.setFloat64(start + size - NUMBER_BYTES, value, true);
  });
  return bytes;
}

function record(kind: number, ...parts: Uint8Array[]): Uint8Array<ArrayBuffer> {
  const content = joined(...parts);
  return joined(new Uint8Array([kind]), u64(content.length), content);
}

function joined(...parts: readonly Uint8Array[]): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(parts.reduce((sum, each) => sum + each.length, 0));
  let at = 0;
  for (const each of parts) {
    bytes.set(each, at);
    at += each.length;
  }
  return bytes;
}

function u16(value: number): Uint8Array {
  return new Uint8Array([value & 0xff, value >> 8]);
}

function u32(value: number): Uint8Array {
  const bytes = new Uint8Array(4);
  new DataView(bytes.buffer).setUint32(0, value, true);
  return bytes;
}

function u64(value: number | bigint): Uint8Array {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setBigUint64(0, BigInt(value), true);
  return bytes;
}

function text(value: string): Uint8Array {
  return prefixed(utf8.encode(value));
}

/** A map with one entry, none without a value. */
function map(key: string, value: string): Uint8Array {
  if (!value) return prefixed(new Uint8Array(0));
  return prefixed(joined(text(key), text(value)));
}

function prefixed(content: Uint8Array): Uint8Array {
  return joined(u32(content.length), content);
}
