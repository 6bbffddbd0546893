// Compiles a message type into closures that read a message. No code is generated, because the page's Content Security
// Policy forbids it.
import {
  fixedSize,
  type Node,
  PRIMITIVE_BYTES,
  type Primitive,
  type StructNode,
  smallestSize,
} from "./schema.ts";
import type { Stamp } from "./stamp.ts";

export type NumberArray =
  | Int8Array
  | Uint8Array
  | Int16Array
  | Uint16Array
  | Int32Array
  | Uint32Array
  | BigInt64Array
  | BigUint64Array
  | Float32Array
  | Float64Array;
/** A decoded value. Arrays of numbers are typed arrays (of bool: Uint8Array), 64-bit integers are bigint. */
export type Value = boolean | number | bigint | string | Stamp | NumberArray | Value[] | Message;
export interface Message {
  [field: string]: Value;
}

/** A message that does not fit its definition. */
export class DecodeError extends Error {}

// Elements without content have no bytes, so the payload's length does not limit their number.
const MAX_EMPTY_ELEMENTS = 256;

/** A position in a payload; every read is checked against the end of the payload. */
export class Cursor {
  view: DataView;
  bytes: Uint8Array;
  offset = 0;
  constructor(bytes: Uint8Array) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }
  /** Moves on by `size` bytes and returns where they begin. */
  skip(size: number): number {
    const start = this.offset;
    if (size > this.bytes.length - start) {
      throw new DecodeError(
        `the message ends at byte ${this.bytes.length}, but byte ${start + size} is needed`,
      );
    }
    this.offset = start + size;
    return start;
  }
  /** Reads the length of a variable array; `smallest` is the minimum size of an element. */
  count(smallest: number): number {
    const count = this.view.getUint32(this.skip(4), true);
    const maxCount = smallest > 0 ? (this.bytes.length - this.offset) / smallest : MAX_EMPTY_ELEMENTS;
    if (count > maxCount)
      throw new DecodeError(`an array claims ${count} elements, more than the message can hold`);
    return count;
  }
}

export type Read = (cursor: Cursor) => Value;
type TypedArray = { new (buffer: ArrayBufferLike, offset: number, length: number): NumberArray };

const ARRAYS: Record<Primitive, TypedArray> = {
  bool: Uint8Array,
  int8: Int8Array,
  uint8: Uint8Array,
  int16: Int16Array,
  uint16: Uint16Array,
  int32: Int32Array,
  uint32: Uint32Array,
  int64: BigInt64Array,
  uint64: BigUint64Array,
  float32: Float32Array,
  float64: Float64Array,
};

const SCALARS: Record<Primitive, Read> = {
  bool: (cursor) => cursor.view.getUint8(cursor.skip(1)) !== 0,
  int8: (cursor) => cursor.view.getInt8(cursor.skip(1)),
  uint8: (cursor) => cursor.view.getUint8(cursor.skip(1)),
  int16: (cursor) => cursor.view.getInt16(cursor.skip(2), true),
  uint16: (cursor) => cursor.view.getUint16(cursor.skip(2), true),
  int32: (cursor) => cursor.view.getInt32(cursor.skip(4), true),
  uint32: (cursor) => cursor.view.getUint32(cursor.skip(4), true),
  int64: (cursor) => cursor.view.getBigInt64(cursor.skip(8), true),
  uint64: (cursor) => cursor.view.getBigUint64(cursor.skip(8), true),
  float32: (cursor) => cursor.view.getFloat32(cursor.skip(4), true),
  float64: (cursor) => cursor.view.getFloat64(cursor.skip(8), true),
};

// As in Python, a byte order mark is a part of the text.
const text = new TextDecoder("utf-8", { ignoreBOM: true });

function readString(cursor: Cursor): string {
  const length = cursor.count(1);
  const start = cursor.skip(length);
  return text.decode(cursor.bytes.subarray(start, start + length));
}

function readTime(cursor: Cursor): Stamp {
  const start = cursor.skip(8);
  return { sec: cursor.view.getUint32(start, true), nsec: cursor.view.getUint32(start + 4, true) };
}

function readDuration(cursor: Cursor): Stamp {
  const start = cursor.skip(8);
  return { sec: cursor.view.getInt32(start, true), nsec: cursor.view.getInt32(start + 4, true) };
}

/** Returns a typed array over the payload; the bytes are copied only if they are not aligned. */
export function numberArray(cursor: Cursor, type: Primitive, count: number): NumberArray {
  const size = PRIMITIVE_BYTES[type];
  const start = cursor.bytes.byteOffset + cursor.skip(count * size);
  const Make = ARRAYS[type];
  if (start % size === 0) return new Make(cursor.bytes.buffer, start, count);
  return new Make(cursor.bytes.buffer.slice(start, start + count * size), 0, count);
}

/** Compiles the reader of a node. */
export function reader(node: Node): Read {
  switch (node.kind) {
    case "primitive":
      return SCALARS[node.type];
    case "string":
      return readString;
    case "time":
      return readTime;
    case "duration":
      return readDuration;
    case "array": {
      const { element, length } = node;
      const smallest = smallestSize(element);
      const count = length === undefined ? (cursor: Cursor) => cursor.count(smallest) : () => length;
      if (element.kind === "primitive") {
        const type = element.type;
        return (cursor) => numberArray(cursor, type, count(cursor));
      }
      const read = reader(element);
      return (cursor) => {
        const values: Value[] = [];
        for (let left = count(cursor); left > 0; left--) values.push(read(cursor));
        return values;
      };
    }
    case "struct": {
      const names = node.fields.map((each) => each.name);
      const reads = node.fields.map((each) => reader(each.node));
      return (cursor) => {
        const message: Message = {};
        for (let index = 0; index < reads.length; index++) message[names[index]!] = reads[index]!(cursor);
        return message;
      };
    }
  }
}

/** Compiles the decoder of a type; it throws DecodeError when a payload does not fit. */
export function decoder(type: StructNode): (payload: Uint8Array) => Message {
  const read = reader(type);
  return (payload) => {
    const cursor = new Cursor(payload);
    const message = read(cursor) as Message;
    if (cursor.offset !== payload.length) {
      throw new DecodeError(
        `${type.name} ends at byte ${cursor.offset} of a message of ${payload.length} bytes`,
      );
    }
    return message;
  };
}

/** Compiles a function that moves a cursor over a node without decoding it. */
export function skipper(node: Node): (cursor: Cursor) => void {
  const size = fixedSize(node);
  if (size !== undefined) return (cursor) => void cursor.skip(size);
  if (node.kind === "string") return (cursor) => void cursor.skip(cursor.count(1));
  if (node.kind === "array") {
    const { element, length } = node;
    const smallest = smallestSize(element);
    const elementSize = fixedSize(element);
    if (elementSize !== undefined) return (cursor) => void cursor.skip(cursor.count(smallest) * elementSize);
    const skipElement = skipper(element);
    return (cursor) => {
      for (let left = length ?? cursor.count(smallest); left > 0; left--) skipElement(cursor);
    };
  }
  const skips = (node as StructNode).fields.map((each) => skipper(each.node));
  return (cursor) => {
    for (const skip of skips) skip(cursor);
  };
}
