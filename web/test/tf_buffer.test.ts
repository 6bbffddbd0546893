import assert from "node:assert/strict";
import { test } from "node:test";
import { compose, eulerDegrees, invert, type Quaternion, type Transform } from "../src/scene/rigid.ts";
import { TfBuffer } from "../src/scene/tf_buffer.ts";

function turned(yaw: number, x: number, y = 0, z = 0): Transform {
  return { translation: [x, y, z], rotation: [0, 0, Math.sin(yaw / 2), Math.cos(yaw / 2)] };
}

function near(actual: readonly number[], expected: readonly number[]): void {
  actual.forEach((value, i) => {
    assert.ok(Math.abs(value - (expected[i] as number)) < 1e-9, `${actual} is not ${expected}`);
  });
}

function found(buffer: TfBuffer, target: string, source: string, atS: number | null = null): Transform {
  const result = buffer.lookup(target, source, atS);
  assert.notEqual(typeof result, "string", String(result));
  return (result as { transform: Transform }).transform;
}

test("a lookup goes up and down the tree", () => {
  const tf = new TfBuffer();
  tf.insert("map", "odom", 1, turned(0, 5), true, 0);
  tf.insert("/odom", "/base", 1, turned(Math.PI / 2, 1), false, 0);
  tf.insert("base", "laser", 1, turned(0, 0.2), true, 0);
  near(found(tf, "map", "laser").translation, [6, 0.2, 0]);
  near(found(tf, "laser", "map").translation, invert(found(tf, "map", "laser")).translation);
  near(compose(found(tf, "laser", "odom"), found(tf, "odom", "laser")).translation, [0, 0, 0]);
  assert.equal(tf.root("laser"), "map");
});

test("a time between two transforms is interpolated", () => {
  const tf = new TfBuffer();
  tf.insert("odom", "base", 1, turned(0, 0), false, 0);
  tf.insert("odom", "base", 2, turned(Math.PI / 2, 2), false, 0);
  const middle = found(tf, "odom", "base", 1.5);
  near(middle.translation, [1, 0, 0]);
  near(eulerDegrees(middle.rotation), [0, 0, 45]);
});

test("a failed lookup has a reason", () => {
  const tf = new TfBuffer();
  tf.insert("a", "b", 1, turned(0, 0), false, 0);
  tf.insert("c", "d", 1, turned(0, 0), false, 0);
  assert.match(String(tf.lookup("a", "d")), /d and a are not connected/);
  assert.match(String(tf.lookup("a", "x")), /Nothing publishes the frame x/);
  assert.match(String(tf.lookup("a", "b", 3)), /b is 2.0 s old/);
});

test("transforms that tf2 ignores are ignored, with the reason", () => {
  const tf = new TfBuffer();
  tf.insert("odom", "base", 1, turned(0, 1), false, 0);
  tf.insert("odom", "base", 2, turned(0, Number.NaN), false, 0);
  tf.insert("odom", "arm", 1, turned(Number.POSITIVE_INFINITY, 1), true, 0);
  near(found(tf, "odom", "base").translation, [1, 0, 0]);
  const reason = "ROS ignores the frame arm: its rotation (0, 0, NaN, NaN) is not a unit quaternion.";
  assert.equal(tf.lookup("odom", "arm"), reason);
  tf.insert("odom", "hand", 1, { translation: [0, 0, 0], rotation: [0, 0, 0, 0] }, true, 0);
  assert.match(String(tf.lookup("odom", "hand")), /its rotation \(0, 0, 0, 0\) is not a unit quaternion/);
  tf.insert("odom", "base", 3, turned(0, 2), false, 0);
  assert.deepEqual(
    tf.problems().map((each) => each.split(":")[0]),
    ["ROS ignores the frame arm", "ROS ignores the frame hand"],
  );
});

test("a loop of frames ends a lookup", () => {
  const tf = new TfBuffer();
  tf.insert("a", "b", 1, turned(0, 1), false, 0);
  tf.insert("b", "a", 1, turned(0, 1), false, 0);
  assert.equal(typeof tf.lookup("a", "b"), "object");
  assert.equal(typeof tf.lookup("a", "z"), "string");
  tf.insert("b", "c", 1, turned(0, 1), false, 0);
  assert.deepEqual(tf.problems(), ["These frames form a loop: a, b."]);
});

test("histories are bounded in time and number", () => {
  const tf = new TfBuffer();
  for (let i = 0; i < 5000; i++) tf.insert("odom", "base", i / 100, turned(0, i), false, 0);
  const { samples } = tf.edges.get("base")!;
  assert.ok(samples.length <= 1000);
  assert.ok(samples.at(-1)!.timeS - samples[0]!.timeS >= 9);
  // A simulation that starts again begins a new history.
  tf.insert("odom", "base", 0.5, turned(0, 7), false, 0);
  near(found(tf, "odom", "base").translation, [7, 0, 0]);
});

test("slow transforms keep their history", () => {
  const tf = new TfBuffer();
  for (let i = 0; i < 100; i++) {
    tf.insert("odom", "base", i, turned(0, i), false, 0);
    near(found(tf, "odom", "base").translation, [i, 0, 0]);
  }
  near(found(tf, "odom", "base", 90.5).translation, [90.5, 0, 0]);
});

test("late samples keep their place", () => {
  const tf = new TfBuffer();
  for (const timeS of [1, 3, 2]) tf.insert("odom", "base", timeS, turned(0, timeS), false, 0);
  near(found(tf, "odom", "base", 2.5).translation, [2.5, 0, 0]);
});

test("a flood of frames is bounded, and zero quaternions are no rotation", () => {
  const tf = new TfBuffer();
  for (let i = 0; i < 10_000; i++) tf.insert("map", `f${i}`, 1, turned(0, 0), true, 0);
  assert.equal(tf.edges.size, 4096);
  const zero: Quaternion = [0, 0, 0, 1];
  near(eulerDegrees(zero), [0, 0, 0]);
});

test("when the clock is set back, only static transforms are kept", () => {
  const tf = new TfBuffer();
  tf.insert("map", "base", 100, turned(0, 1), false, 0);
  tf.insert("base", "laser", 0, turned(0, 0, 1), true, 0);
  tf.clearHistory();
  assert.match(tf.lookup("map", "base") as string, /no transform yet/);
  tf.insert("map", "base", 95, turned(0, 2), false, 0);
  near(found(tf, "map", "laser").translation, [2, 1, 0]);
});
