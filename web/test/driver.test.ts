// A held control drives only as long as its user means it to.
import assert from "node:assert/strict";
import { test } from "node:test";
import { signal } from "@preact/signals";
import type { Lease } from "../src/connection/protocol.ts";
import { DEFAULT_LIMITS } from "../src/panels/drive/commands.ts";
import { Driver } from "../src/panels/drive/driver.ts";
import type { Robot } from "../src/store/robot.ts";
import { Topic } from "../src/store/topics.ts";

const TWIST =
  "Vector3 linear\nVector3 angular\n" +
  `${"=".repeat(80)}\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z`;
const AHEAD = { x: 0, y: 1 };

function stage(isConnected = true) {
  const sent: number[] = [];
  let onLease = (_: Lease) => {};
  const gateway = {
    advertiseDriven: (_channel: object, _name: string, report: typeof onLease) => {
      onLease = report;
      return 1;
    },
    publish: (_id: number, bytes: Uint8Array) =>
      sent.push(new DataView(bytes.buffer, bytes.byteOffset).getFloat64(0, true)),
    unadvertise: () => {},
  };
  const robot = { gateway, canCommand: signal(isConnected) } as unknown as Robot;
  const topic = new Topic("/cmd_vel", "geometry_msgs/Twist", TWIST, undefined);
  const driver = new Driver(robot, topic, DEFAULT_LIMITS);
  return { driver, sent, lease: (state: Lease["state"]) => onLease({ state, driver: "other" }) };
}

test("a control held while another client drives needs a new touch", () => {
  const { driver, sent, lease } = stage();
  lease("taken");
  driver.hold(AHEAD);
  lease("free");
  driver.hold(AHEAD);
  assert.deepEqual(sent, []);
  driver.release();
  driver.hold(AHEAD);
  assert.equal(sent.length, 1);
  assert.ok(sent[0]! > 0);
  driver.dispose();
});

test("a stop is sent while another client drives", () => {
  const { driver, sent, lease } = stage();
  lease("taken");
  driver.stop();
  assert.equal(sent[0], 0);
  driver.dispose();
});

test("a page that was suspended does not continue to drive", async (context) => {
  const { driver, sent } = stage();
  driver.hold(AHEAD);
  const now = performance.now.bind(performance);
  context.mock.method(performance, "now", () => now() + 5000);
  while (driver.stick.value.y !== 0) await new Promise((resolve) => setTimeout(resolve, 10));
  driver.hold(AHEAD);
  assert.equal(sent.length, 1);
  // The robot waits for a stop.
  driver.release();
  driver.hold(AHEAD);
  assert.equal(sent[1], 0);
  assert.ok(sent[2]! > 0);
  driver.dispose();
});

test("after a stalled network, a control that is still held needs a new touch", (context) => {
  const { driver, sent, lease } = stage();
  driver.hold(AHEAD);
  lease("driving");
  const now = performance.now.bind(performance);
  context.mock.method(performance, "now", () => now() + 1500);
  lease("free");
  assert.ok(driver.isBlocked.value);
  driver.hold(AHEAD);
  assert.equal(sent.length, 1);
  driver.release();
  driver.hold(AHEAD);
  assert.equal(sent[1], 0);
  assert.ok(sent[2]! > 0);
  driver.dispose();
});

test("a control held without a connection does not drive once connected", () => {
  const { driver, sent } = stage(false);
  driver.hold(AHEAD);
  driver.hold(AHEAD);
  assert.deepEqual(sent, []);
  driver.dispose();
});
