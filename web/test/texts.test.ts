import assert from "node:assert/strict";
import { test } from "node:test";
import { boardStatuses } from "../src/panels/boards/board_status.ts";
import { toCsv } from "../src/panels/plots/csv.ts";
import { brief } from "../src/panels/topics/brief.ts";
import { RobotClock } from "../src/plot/robot_clock.ts";
import { Series } from "../src/plot/series.ts";
import { unitOf } from "../src/plot/units.ts";
import { formatFixed, formatNumber } from "../src/shell/format.ts";
import { RateMeter } from "../src/store/rate.ts";
import { parseDefinition } from "../src/wire/definition.ts";

test("numbers as people read them", () => {
  assert.deepEqual(
    [0, 1.5, 0.1234567, 1e-7, 12345678.9, 100].map((each) => formatNumber(each)),
    ["0", "1.5", "0.1235", "1e-7", "1.23e+7", "100"],
  );
  assert.deepEqual([1.23456, 123.456, 5, -0.00001].map(formatFixed), ["1.235", "123.46", "5", "-1.0e-5"]);
});

test("a message in one line", () => {
  assert.equal(
    brief({ header: { seq: 1 }, a: 1, b: [1, 2], c: { sec: 5, nsec: 30_000_000 } }),
    "a: 1 b: [1, 2] c: 5.030 s",
  );
  assert.equal(brief({ data: { sec: -2, nsec: 500_000_000 } }), "-1.500 s");
  assert.equal(brief({ data: "hello" }), "hello");
  assert.match(brief({ a: "x".repeat(100), b: "y".repeat(100) }), /^a: x+ b: y+…$/);
  assert.equal(
    brief({ a: { x_y: 1 }, p: [2.5, 3] }, ["a.x_y", "p[0]", "p[7]"]),
    "a.x y: 1, p[0]: 2.5, p[7]: –",
  );
});

test("units of comments and of types", () => {
  const type = parseDefinition(
    "x/Y",
    "float32 range # range data [m]\nfloat32 speed # in [furlongs]\n# (in deg/s)\nfloat32 turn",
  );
  assert.deepEqual(
    ["range", "speed", "turn"].map((path) => unitOf(type, path)),
    ["m", "", "deg/s"],
  );
  const line = `\n${"=".repeat(80)}\n`;
  const twist = parseDefinition(
    "geometry_msgs/Twist",
    `Vector3 linear\nVector3 angular${line}MSG: geometry_msgs/Vector3\nfloat64 x`,
  );
  assert.deepEqual(
    ["linear.x", "angular.x"].map((path) => unitOf(twist, path)),
    ["m/s", "rad/s"],
  );
});

test("a simulated clock may run slowly", () => {
  let simulatedNs: bigint | undefined = 5_000_000_000n;
  const clock = new RobotClock(() => simulatedNs);
  clock.note(4, performance.now());
  assert.equal(clock.nowS(), 5);
  simulatedNs = undefined;
  assert.ok(Math.abs(clock.nowS() - 4) < 1);
});

test("rates, and values that are stale after three periods", () => {
  const rate = new RateMeter();
  for (let ms = 0; ms <= 4000; ms += 500) rate.add(ms, 100);
  assert.equal(rate.hertz(4000), 2);
  assert.equal(rate.bytesPerSecond(4000), 200);
  assert.equal(rate.isStale(5400), false);
  assert.equal(rate.isStale(5600), true);
});

test("the robot's clock follows one that was set", () => {
  const clock = new RobotClock(() => undefined);
  const at = () => clock.nowS() - performance.now() / 1000;
  clock.note(1000, 0);
  clock.note(1001, 1200);
  assert.ok(Math.abs(at() - 1000) < 0.01);
  clock.note(5000, 2000);
  assert.equal(Math.round(at()), 4998);
});

test("a table of the values that a plot shows", () => {
  const [a, b] = ["/a.x", '/b.y["]'].map((id) => new Series(id, new RobotClock(() => undefined))) as [
    Series,
    Series,
  ];
  for (let index = 0; index < 3; index++) a.buffer.push(index, index);
  b.buffer.push(1, 5);
  assert.equal(toCsv([a, b], 0.5, 10), 'time,/a.x,"/b.y[""]"\n1.000000,1,5\n2.000000,2,\n');
});

test("a board's status from its diagnostics", () => {
  const value = (key: string, text: string) => ({ key, value: text });
  const [board, ...others] = boardStatuses({
    status: [
      {
        level: 1,
        name: "uno: rosserial",
        message: "m",
        hardware_id: "h",
        values: [
          value("publisher /a type", "x/Y"),
          value("publisher /a [Hz]", "5.0"),
          value("finding slow-loop", "it is late; call spinOnce more often"),
        ],
      },
      { level: 0, name: "other", message: "", hardware_id: "", values: [] },
    ],
  });
  assert.equal(others.length, 0);
  assert.equal(board?.name, "uno");
  assert.equal(board?.endpoints[0]?.hertz, 5);
  assert.deepEqual(board?.findings, [
    { code: "slow-loop", seen: "it is late", action: "call spinOnce more often" },
  ]);
});
