// Any definition or message of a peer is decoded or refused with an error.
import assert from "node:assert/strict";
import { test } from "node:test";
import { DecodeError, decoder } from "../src/wire/decode.ts";
import { DefinitionError, parseDefinition } from "../src/wire/definition.ts";
import { EncodeError, encoder } from "../src/wire/encode.ts";
import { PathError, pathReader } from "../src/wire/path.ts";

const LINE = `\n${"=".repeat(80)}\n`;

/** A generator of random numbers below a bound, the same in each run. */
function generator(seed: number): (below: number) => number {
  let state = seed;
  return (below) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
}

const REFUSED: [string, string][] = [
  ["contains itself", `a/B b${LINE}MSG: a/B\na/A a`],
  ["does not define", "a/Missing x"],
  ["not a field", "int32"],
  ["not a field", "int32 a b"],
  ["not a field", "__proto__ x y z"],
  ["two fields", "int32 a\nint32 a"],
  ["does not define", "constructor x"],
  ["elements", "int32[99999999999] a"],
  ["values", `a/B[65536] b${LINE}MSG: a/B\na/C[65536] c${LINE}MSG: a/C\nint8 x`],
  ["MSG", `int8 a${LINE}nothing`],
  ["characters", `#${"x".repeat(1 << 20)}`],
];

test("definitions that are refused, with the reason", () => {
  for (const [reason, text] of REFUSED) {
    assert.throws(
      () => parseDefinition("a/A", text),
      (error: Error) => error instanceof DefinitionError && error.message.includes(reason),
      text.slice(0, 60),
    );
  }
});

test("types nested too deep are refused", () => {
  let text = "a/T0 x";
  for (let index = 0; index < 100; index++)
    text += `${LINE}MSG: a/T${index}\n${index < 99 ? `a/T${index + 1} x` : "int8 y"}`;
  assert.throws(() => parseDefinition("a/A", text), /deeper/);
});

test("random definitions end in a type or a DefinitionError", () => {
  const random = generator(1);
  const words = [
    "int32",
    "string",
    "a/B",
    "B",
    "Header",
    "[]",
    "[3]",
    "x",
    "y",
    "=",
    "5",
    "#",
    "\n",
    " ",
    "time",
    LINE,
    "MSG: a/B\n",
    "bool",
    "__proto__",
    "uint8[]",
  ];
  let accepted = 0;
  for (let round = 0; round < 20_000; round++) {
    let text = "";
    for (let left = random(14); left >= 0; left--)
      text += `${words[random(words.length)]}${random(3) ? " " : ""}`;
    try {
      const type = parseDefinition("a/A", text);
      encoder(type)({});
      accepted++;
    } catch (error) {
      assert.ok(error instanceof DefinitionError, `${text}: ${error}`);
    }
  }
  assert.ok(accepted > 100, `only ${accepted} were accepted`);
});

test("random bytes end in a message or a DecodeError, and cost little", () => {
  const random = generator(2);
  const definition = `std_msgs/Header header\nstring[] names\nfloat64[3] p\nuint8[] data\na/B[] parts\na/Empty[] none\ntime t${LINE}MSG: a/B\nstring s\nint64[] n${LINE}MSG: a/Empty\n${LINE}MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id`;
  const type = parseDefinition("a/A", definition);
  const decode = decoder(type);
  const readers = ["p[1]", "parts[0].n[0]", "t", "data[:]"].map((path) => pathReader(type, path));
  const valid = encoder(type)({
    names: ["a", "b"],
    data: [1, 2, 3],
    parts: [{ s: "x", n: [1n] }],
    none: [{}, {}],
  });
  for (let round = 0; round < 20_000; round++) {
    const bytes = round % 2 ? valid.slice() : new Uint8Array(random(200));
    for (let left = round % 2 ? 1 + random(4) : bytes.length; left > 0; left--) {
      if (bytes.length) bytes[random(bytes.length)] = random(4) ? random(256) : 255;
    }
    try {
      decode(bytes);
    } catch (error) {
      assert.ok(error instanceof DecodeError, String(error));
    }
    for (const each of readers) assert.equal(typeof each.read(bytes), "number");
  }
});

test("elements without content do not multiply", () => {
  const decode = decoder(parseDefinition("a/A", `a/Empty[] none${LINE}MSG: a/Empty\n`));
  assert.throws(() => decode(new Uint8Array([255, 255, 255, 255])), DecodeError);
});

test("values that do not fit are refused, with the field's name", () => {
  const encode = encoder(parseDefinition("a/A", "uint8 a\nint64 b\nstring c\nfloat64[3] d\ntime e"));
  const wrong: [object, string][] = [
    [{ a: 256 }, "a must be uint8"],
    [{ a: "1" }, "a must be uint8"],
    [{ b: 2n ** 63n }, "b must be int64"],
    [{ c: 5 }, "c must be string"],
    [{ d: [1, 2] }, "d must have 3"],
    [{ e: 5 }, "e must be time"],
    [{ e: { sec: -1 } }, "e.sec must be uint32"],
  ];
  for (const [value, text] of wrong) {
    assert.throws(
      () => encode(value),
      (error: Error) => error instanceof EncodeError && error.message.includes(text),
    );
  }
});

test("paths that a type does not have are refused", () => {
  const type = parseDefinition(
    "a/A",
    "string s\nfloat64[3] d\na/B b\nMSG".replace("\nMSG", `${LINE}MSG: a/B\nint8 x`),
  );
  for (const path of [
    "",
    "x",
    "s",
    "d",
    "d[3]",
    "d[:].x",
    "b",
    "b.y",
    "b.x.z",
    "b[0]",
    "..",
    "d[-1]",
    "__proto__",
  ]) {
    assert.throws(() => pathReader(type, path), PathError, path);
  }
  const payload = encoder(type)({ s: "abc", d: [1, 2, 3], b: { x: -4 } });
  assert.equal(pathReader(type, "d[2]").read(payload), 3);
  assert.equal(pathReader(type, "b.x").read(payload), -4);
  assert.deepEqual([...pathReader(type, "d[:]").readAll(payload)], [1, 2, 3]);
});
