import assert from "node:assert/strict";
import { test } from "node:test";
import { parseExact, stringifyExact } from "../src/connection/exact_json.ts";
import { choicesOf } from "../src/forms/choices.ts";
import { formatList, formatStamp, parseList, parseNumber, parseStamp } from "../src/forms/numbers.ts";
import { controlKind, fitsCard } from "../src/panels/controls/control_kind.ts";
import { controllableTopics } from "../src/panels/controls/controllable.ts";
import { commandOf, DEFAULT_LIMITS, withDeadZone } from "../src/panels/drive/commands.ts";
import { parameterTree, readValue } from "../src/panels/parameters/parameter_tree.ts";
import { isPlumbing } from "../src/panels/services/plumbing.ts";
import { Topic } from "../src/store/topics.ts";
import { parseDefinition } from "../src/wire/definition.ts";

test("numbers are read as their type", () => {
  assert.equal(parseNumber("uint8", "255"), 255);
  assert.equal(parseNumber("int32", " -7 "), -7);
  assert.equal(parseNumber("uint16", "0x10"), 16);
  assert.equal(parseNumber("int8", "-0x10"), -16);
  assert.equal(parseNumber("int64", "9007199254740993"), 9007199254740993n);
  assert.equal(parseNumber("float32", "1,5"), 1.5);
  assert.ok(Number.isNaN(parseNumber("float64", "nan")));
  assert.equal(parseNumber("float64", ""), 0);
  for (const [type, text] of [
    ["uint8", "256"],
    ["uint8", "-1"],
    ["int8", "1.5"],
    ["int8", "-"],
    ["float64", "x"],
  ] as const)
    assert.equal(typeof parseNumber(type, text), "string", `${type} ${text}`);
});

test("parameters keep the digits of 64 bit integers", () => {
  const big = parseExact('[4611686018427387905, 1.5, 3, "9007199254740993"]');
  assert.deepEqual(big, [4611686018427387905n, 1.5, 3, "9007199254740993"]);
  assert.equal(stringifyExact({ big }), '{"big":[4611686018427387905,1.5,3,"9007199254740993"]}');
  assert.equal(readValue("-4611686018427387905", 4611686018427387904n), -4611686018427387905n);
  assert.throws(() => readValue("true", 4611686018427387904n), /a number/);
});

test("lists are read by their elements", () => {
  const bytes = { kind: "primitive", type: "uint8" } as const;
  assert.deepEqual(parseList(bytes, "[1, 2,3]"), [1, 2, 3]);
  assert.deepEqual(parseList(bytes, ""), []);
  assert.equal(typeof parseList(bytes, "1,300"), "string");
  assert.deepEqual(parseList({ kind: "primitive", type: "bool" }, "true, 0"), [true, false]);
  assert.deepEqual(parseList({ kind: "string" }, "a, b"), ["a", "b"]);
});

test("lists of texts keep commas, quotes and brackets", () => {
  const texts = ["a, b", 'say "hi"', "[x]", "", " c", "äöü"];
  assert.deepEqual(parseList({ kind: "string" }, formatList(texts)), texts);
  assert.deepEqual(parseList({ kind: "string" }, '["a, b", c]'), ["a, b", "c"]);
  for (const wrong of ['"a', '"a" b', 'a "b"', '"\\x"'])
    assert.equal(typeof parseList({ kind: "string" }, wrong), "string", wrong);
});

test("times are read to the nanosecond, and within their type", () => {
  assert.deepEqual(parseStamp("time", "1700000000.123456789"), { sec: 1700000000, nsec: 123456789 });
  assert.deepEqual(parseStamp("duration", "-0,5"), { sec: -1, nsec: 500000000 });
  assert.deepEqual(parseStamp("time", ""), { sec: 0, nsec: 0 });
  for (const text of ["0", "0.000000001", "-0.5", "-1", "-2147483648", "2147483647.999999999"])
    assert.equal(formatStamp(parseStamp("duration", text) as { sec: number; nsec: number }), text);
  for (const [kind, text] of [
    ["time", "-1"],
    ["time", "4294967296"],
    ["duration", "2147483648"],
    ["time", "1e9"],
    ["time", "now"],
    ["time", "1.0000000001"],
  ] as const)
    assert.equal(typeof parseStamp(kind, text), "string", text);
});

test("constants are choices of the field that they belong to", () => {
  const names = (definition: string, field: string) => {
    const type = parseDefinition("a/B", definition);
    return choicesOf(type, type.fields.find((each) => each.name === field)!).map(
      ({ name, value }) => `${name}=${value}`,
    );
  };
  const range = "uint8 ULTRASOUND=0\nuint8 INFRARED=1\nuint8 radiation_type\nfloat32 range";
  assert.deepEqual(names(range, "radiation_type"), ["ULTRASOUND=0", "INFRARED=1"]);
  assert.deepEqual(names(range, "range"), []);
  const battery = "uint8 STATUS_FULL=4\nuint8 HEALTH_GOOD=1\nuint8 status\nuint8 health\nuint8 other";
  assert.deepEqual(names(battery, "health"), ["GOOD=1"]);
  assert.deepEqual(names(battery, "other"), []);
  // It cannot be known which of two fields has them.
  assert.deepEqual(names("uint8 A=0\nuint8 x\nuint8 y", "x"), []);
  assert.deepEqual(names("byte OK=0\nbyte level\nstring NAME=x y\nstring name", "level"), ["OK=0"]);
  assert.deepEqual(names("uint64 MOST=18446744073709551615\nuint64 x", "x"), ["MOST=18446744073709551615"]);
  // A constant that does not fit the field is not offered as a choice.
  assert.deepEqual(names("int32 X_A=-1\nuint8 x", "x"), []);
});

test("each type has the control that fits", () => {
  const kind = (topic: string, name: string, definition: string) =>
    controlKind(topic, parseDefinition(name, definition));
  assert.equal(kind("/toggle_led", "std_msgs/Empty", "").kind, "button");
  assert.equal(kind("/led", "std_msgs/Bool", "bool data").kind, "toggle");
  assert.deepEqual(kind("/servo", "std_msgs/UInt16", "uint16 data"), {
    kind: "slider",
    field: "data",
    type: "uint16",
    min: 0,
    max: 180,
    step: 1,
  });
  assert.equal(kind("/text", "std_msgs/String", "string data").kind, "text");
  assert.equal(kind("/c", "std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a").kind, "color");
  assert.equal(kind("/x", "a/B", "float32 a\nfloat32 b").kind, "form");
  assert.deepEqual(kind("/pose", "mearm_model/ServoAngles", "int16 servo1\nint16 servo2"), {
    kind: "servos",
    fields: ["servo1", "servo2"],
    min: 0,
    max: 180,
    step: 1,
  });
  assert.equal(kind("/pose", "a/ServoState", "int16 servo\nstring name").kind, "form");
  const small = kind("/servo", "std_msgs/Int8", "int8 data");
  assert.ok(small.kind === "slider" && small.max === 127);
  const speed = kind("/speed", "std_msgs/Int8", "int8 data");
  assert.ok(speed.kind === "slider" && speed.max === 127);
});

test("topics without a publisher can be controlled", () => {
  const topic = (name: string) => [name, new Topic(name, "std_msgs/Bool", "bool data", undefined)] as const;
  const graph = {
    topics: new Map([topic("/led"), topic("/busy"), topic("/rosout"), topic("/seen"), topic("/mine")]),
    subscribers: new Map([
      ["/led", ["/board"]],
      ["/busy", ["/board"]],
      ["/rosout", ["/tool"]],
      ["/seen", ["/gateway"]],
      ["/mine", ["/board"]],
      ["/unknown", ["/board"]],
    ]),
    publishers: new Map([
      ["/busy", ["/driver"]],
      ["/mine", ["/gateway", "/web_teleop"]],
    ]),
    services: new Map(),
    ownNodes: ["/gateway", "/web_teleop"],
    hasBoards: false,
  };
  assert.deepEqual(controllableTopics(graph), ["/led", "/mine"]);
});

test("parameters form a tree and keep their type", () => {
  const tree = parameterTree(
    [
      { name: "/a/x", value: 1 },
      { name: "/a/b/y", value: 2 },
      { name: "node.gain", value: 3 },
    ],
    "",
  );
  assert.deepEqual(
    tree.branches.map((each) => each.name),
    ["a", "node"],
  );
  assert.equal(tree.branches[0]!.branches[0]!.parameters[0]!.name, "y");
  assert.equal(readValue("2.5", 1), 2.5);
  assert.equal(readValue("text", "before"), "text");
  assert.deepEqual(readValue("[1, 2]", [0]), [1, 2]);
  // JSON has no infinity: the parameter would be deleted.
  assert.throws(() => readValue("1e400", 1), /too large/);
  assert.throws(() => readValue('[{"x": -1e400}]', [0]), /too large/);
  for (const [text, before] of [
    ["x", 1],
    ["true", 1],
    ["{", {}],
    ["3", [1]],
  ] as const)
    assert.throws(() => readValue(text, before), { name: "Error" });
});

test("services of every node are plumbing", () => {
  assert.ok(isPlumbing({ name: "/n/get_loggers", type: "roscpp/GetLoggers" }));
  assert.ok(isPlumbing({ name: "/n/describe_parameters", type: "rcl_interfaces/DescribeParameters" }));
  assert.ok(!isPlumbing({ name: "/set_led", type: "std_srvs/SetBool" }));
});

test("a stick becomes the command of the type", () => {
  const twist = parseDefinition(
    "geometry_msgs/Twist",
    "Vector3 linear\nVector3 angular\n" +
      "================================================================================\n" +
      "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z",
  );
  assert.deepEqual(commandOf(twist, { x: 0, y: 1 }, DEFAULT_LIMITS), {
    linear: { x: 0.3 },
    angular: { z: 0 },
  });
  assert.deepEqual(commandOf(twist, { x: 1, y: 0 }, DEFAULT_LIMITS), {
    linear: { x: 0 },
    angular: { z: -1 },
  });
  const control = parseDefinition("arduino_control/ArduinoControl", "float64 dir\nfloat64 speed");
  const full = { linear: 1, angular: 1 };
  assert.deepEqual(commandOf(control, { x: 1, y: 0 }, full), { dir: 90, speed: 1 });
  assert.deepEqual(commandOf(control, { x: 0, y: -1 }, full), { dir: 180, speed: 1 });
  assert.deepEqual(commandOf(control, { x: 0.05, y: 0.05 }, full), { dir: 0, speed: 0 });
});

test("the dead zone begins at 0 and ends at 1", () => {
  assert.deepEqual(withDeadZone({ x: 0.1, y: 0 }), { x: 0, y: 0 });
  assert.ok(Math.abs(withDeadZone({ x: 0.55, y: 0 }).x - 0.5) < 1e-9);
  const { x, y } = withDeadZone({ x: 5, y: 5 });
  assert.ok(Math.abs(Math.hypot(x, y) - 1) < 1e-9);
});

test("a control of many fields is not a card of the overview", () => {
  const topic = (type: string, definition: string) => new Topic("/x", type, definition, undefined);
  assert.equal(fitsCard(topic("std_msgs/Bool", "bool data")), true);
  assert.equal(fitsCard(topic("a/B", "float32 a\nfloat32 b")), false);
  assert.equal(fitsCard(topic("a/B", "nowhere/Type b")), false);
});
