// Compiles a message type into closures that write a message. Missing fields are zero.
import { type Node, PRIMITIVE_BYTES, type Primitive, type StructNode } from "./schema.ts";

/** A value that does not fit its field; the text names the field. */
export class EncodeError extends Error {}

// The limit of one message; the gateway accepts 16 MiB from a client.
const MAX_BYTES = 16 << 20;

class Writer {
  bytes = new Uint8Array(256);
  view = new DataView(this.bytes.buffer);
  length = 0;
  /** Makes room for `size` bytes and returns where they begin. */
  grow(size: number): number {
    const start = this.length;
    const end = start + size;
    if (end > MAX_BYTES) throw new EncodeError(`the message is larger than ${MAX_BYTES} bytes`);
    if (end > this.bytes.length) {
      const larger = new Uint8Array(Math.max(end, this.bytes.length * 2));
      larger.set(this.bytes);
      this.bytes = larger;
      this.view = new DataView(larger.buffer);
    }
    this.length = end;
    return start;
  }
}

type Write = (writer: Writer, value: unknown, where: string) => void;

const RANGES: Partial<Record<Primitive, [number, number]>> = {
  int8: [-128, 127],
  uint8: [0, 255],
  int16: [-32768, 32767],
  uint16: [0, 65535],
  int32: [-2147483648, 2147483647],
  uint32: [0, 4294967295],
};

const SETTERS: Record<Primitive, (view: DataView, offset: number, value: number) => void> = {
  bool: (view, offset, value) => view.setUint8(offset, value),
  int8: (view, offset, value) => view.setInt8(offset, value),
  uint8: (view, offset, value) => view.setUint8(offset, value),
  int16: (view, offset, value) => view.setInt16(offset, value, true),
  uint16: (view, offset, value) => view.setUint16(offset, value, true),
  int32: (view, offset, value) => view.setInt32(offset, value, true),
  uint32: (view, offset, value) => view.setUint32(offset, value, true),
  int64: () => undefined,
  uint64: () => undefined,
  float32: (view, offset, value) => view.setFloat32(offset, value, true),
  float64: (view, offset, value) => view.setFloat64(offset, value, true),
};

function shown(value: unknown): string {
  const text = typeof value === "object" ? Object.prototype.toString.call(value) : String(value);
  return text.length > 40 ? `${text.slice(0, 37)}...` : text;
}

function primitive(type: Primitive): Write {
  const size = PRIMITIVE_BYTES[type];
  if (type === "int64" || type === "uint64") {
    const [low, high] = type === "int64" ? [-(2n ** 63n), 2n ** 63n - 1n] : [0n, 2n ** 64n - 1n];
    return (writer, value, where) => {
      const start = writer.grow(8);
      const whole = typeof value === "number" && Number.isInteger(value) ? BigInt(value) : (value ?? 0n);
      if (typeof whole !== "bigint" || whole < low || whole > high) throw wrong(where, value, type);
      writer.view.setBigUint64(start, BigInt.asUintN(64, whole), true);
    };
  }
  const range = RANGES[type];
  const set = SETTERS[type];
  return (writer, value, where) => {
    const start = writer.grow(size);
    const number = typeof value === "boolean" || typeof value === "bigint" ? Number(value) : (value ?? 0);
    if (typeof number !== "number") throw wrong(where, value, type);
    if (range && !(Number.isInteger(number) && number >= range[0] && number <= range[1])) {
      throw wrong(where, value, type);
    }
    set(writer.view, start, type === "bool" ? Number(number !== 0) : number);
  };
}

function wrong(where: string, value: unknown, type: string): EncodeError {
  return new EncodeError(`${where} must be ${type}, not ${shown(value)}`);
}

const utf8 = new TextEncoder();

function writeString(writer: Writer, value: unknown, where: string): void {
  const text = value ?? "";
  if (typeof text !== "string") throw wrong(where, value, "string");
  const bytes = utf8.encode(text);
  const start = writer.grow(4 + bytes.length);
  writer.view.setUint32(start, bytes.length, true);
  writer.bytes.set(bytes, start + 4);
}

function stamp(kind: "time" | "duration"): Write {
  const part = primitive(kind === "time" ? "uint32" : "int32");
  return (writer, value, where) => {
    if (value !== undefined && (typeof value !== "object" || value === null)) throw wrong(where, value, kind);
    const { sec, nsec } = (value ?? {}) as { sec?: unknown; nsec?: unknown };
    part(writer, sec, `${where}.sec`);
    part(writer, nsec, `${where}.nsec`);
  };
}

function writerOf(node: Node): Write {
  switch (node.kind) {
    case "primitive":
      return primitive(node.type);
    case "string":
      return writeString;
    case "time":
    case "duration":
      return stamp(node.kind);
    case "array": {
      const { length } = node;
      const write = writerOf(node.element);
      const isBytes = node.element.kind === "primitive" && node.element.type === "uint8";
      return (writer, value, where) => {
        const values = value ?? [];
        if (!Array.isArray(values) && !ArrayBuffer.isView(values)) throw wrong(where, value, "a list");
        const list = values as ArrayLike<unknown>;
        if (isBytes && length === undefined && values instanceof Uint8Array) {
          // A uint8[], such as a picture.
          const start = writer.grow(4 + values.length);
          writer.view.setUint32(start, values.length, true);
          writer.bytes.set(values, start + 4);
          return;
        }
        if (length === undefined) {
          const start = writer.grow(4);
          writer.view.setUint32(start, list.length, true);
        } else if (list.length !== length && value !== undefined) {
          throw new EncodeError(`${where} must have ${length} elements, not ${list.length}`);
        }
        const count = length ?? list.length;
        for (let index = 0; index < count; index++) write(writer, list[index], `${where}[${index}]`);
      };
    }
    case "struct": {
      const fields = node.fields.map((each) => ({ name: each.name, write: writerOf(each.node) }));
      return (writer, value, where) => {
        if (value !== undefined && (typeof value !== "object" || value === null)) {
          throw wrong(where, value, node.name);
        }
        const given = (value ?? {}) as Record<string, unknown>;
        for (const { name, write } of fields) {
          write(
            writer,
            Object.hasOwn(given, name) ? given[name] : undefined,
            where ? `${where}.${name}` : name,
          );
        }
      };
    }
  }
}

/** Compiles the encoder of a type; it throws EncodeError when a value does not fit. */
export function encoder(type: StructNode): (message: unknown) => Uint8Array {
  const write = writerOf(type);
  return (message) => {
    const writer = new Writer();
    write(writer, message ?? {}, "");
    return writer.bytes.slice(0, writer.length);
  };
}
