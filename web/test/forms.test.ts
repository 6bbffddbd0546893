import assert from "node:assert/strict";
import { test } from "node:test";
import { parseExact, stringifyExact } from "../src/connection/exact_json.ts";
import { parseList, parseNumber } from "../src/forms/numbers.ts";
import { controlKind } from "../src/panels/controls/control_kind.ts";
import { controllableTopics } from "../src/panels/controls/controllable.ts";
import { fitsCard } from "../src/panels/controls/controls.ts";
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
  const speed = kind("/speed", "std_msgs/Int8", "int8 data");
  assert.ok(speed.kind === "slider" && speed.max === 127);
});

test("what nobody publishes can be controlled", () => {
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

test("a control of many fields is no card of the overview", () => {
  const topic = (type: string, definition: string) => new Topic("/x", type, definition, undefined);
  assert.equal(fitsCard(topic("std_msgs/Bool", "bool data")), true);
  assert.equal(fitsCard(topic("a/B", "float32 a\nfloat32 b")), false);
  assert.equal(fitsCard(topic("a/B", "nowhere/Type b")), false);
});
