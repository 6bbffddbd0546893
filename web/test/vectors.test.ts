// The decoder, the encoder and the path reader agree with Python's `serde` on every bundled type.
import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { DecodeError, decoder, type Message, type Value } from "../src/wire/decode.ts";
import { parseDefinition } from "../src/wire/definition.ts";
import { encoder } from "../src/wire/encode.ts";
import { numericPaths, pathReader } from "../src/wire/path.ts";
import type { Node } from "../src/wire/schema.ts";

interface Vector {
  name: string;
  definition: string;
  messages: { payload: string; value: unknown }[];
}

const file = new URL("../build/vectors.json", import.meta.url);
assert.ok(
  existsSync(file),
  "web/build/vectors.json is missing: run `make check`, or scripts/write-page-vectors",
);
const vectors = JSON.parse(readFileSync(file, "utf8")) as Vector[];

/** A decoded value in the vectors' form. */
function plain(node: Node, value: Value): unknown {
  if (node.kind === "struct") {
    const message = value as Message;
    return Object.fromEntries(node.fields.map((each) => [each.name, plain(each.node, message[each.name]!)]));
  }
  if (node.kind === "array")
    return Array.from(value as ArrayLike<Value>, (each) => plain(node.element, each));
  if (typeof value === "bigint") return String(value);
  if (typeof value === "number" && !Number.isFinite(value)) return value > 0 ? "inf" : "-inf";
  if (node.kind === "primitive" && node.type === "bool") return Boolean(value);
  return value;
}

/** The number at a path of a decoded message, as the path reader gives it. */
function at(message: Message, path: string): number {
  let value: Value = message;
  for (const step of path.split(".")) value = (value as Message)[step]!;
  return Number(value);
}

test("every bundled type", () => {
  assert.ok(vectors.length > 200, `only ${vectors.length} types`);
  for (const { name, definition, messages } of vectors) {
    const type = parseDefinition(name, definition);
    const decode = decoder(type);
    const encode = encoder(type);
    for (const { payload, value } of messages) {
      const bytes = new Uint8Array(Buffer.from(payload, "base64"));
      const message = decode(bytes);
      assert.deepEqual(plain(type, message), value, name);
      assert.deepEqual(encode(message), bytes, name);
      // One byte further in its buffer, where arrays are not aligned.
      const shifted = new Uint8Array(bytes.length + 1);
      shifted.set(bytes, 1);
      assert.deepEqual(plain(type, decode(shifted.subarray(1))), value, name);
      for (const path of numericPaths(type)) {
        const reader = pathReader(type, path);
        if (!reader.isArray) assert.deepEqual(reader.read(bytes), at(message, path), `${name} ${path}`);
      }
    }
  }
});

test("a message cut short is refused at every length", () => {
  for (const { name, definition, messages } of vectors) {
    const decode = decoder(parseDefinition(name, definition));
    const bytes = new Uint8Array(Buffer.from(messages[0]!.payload, "base64"));
    for (let length = 0; length < bytes.length; length += 1 + (bytes.length >> 6)) {
      assert.throws(() => decode(bytes.subarray(0, length)), DecodeError, name);
    }
  }
});
