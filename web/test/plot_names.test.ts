// Names as people type them for rqt_plot.
import assert from "node:assert/strict";
import { test } from "node:test";
import { seriesOfName, seriesOfTyped } from "../src/plot/plot_names.ts";
import { Topic } from "../src/store/topics.ts";

const POINT = "float64 x\nfloat64 y\nfloat64 z";
const topics = new Map(
  [
    { name: "/imu", schemaName: "geometry_msgs/Point", schema: POINT },
    {
      name: "/imu/pose",
      schemaName: "test/Pose",
      schema: `geometry_msgs/Point at\n${"=".repeat(80)}\nMSG: geometry_msgs/Point\n${POINT}`,
    },
    { name: "/scan", schemaName: "test/Scan", schema: "float32[] ranges" },
    { name: "/count", schemaName: "std_msgs/Int16", schema: "int16 data" },
  ].map(({ name, ...schema }, id) => [
    name,
    Topic.ofChannel({ id, topic: name, encoding: "ros1", ...schema }),
  ]),
);

test("names of rqt_plot become series", () => {
  assert.deepEqual(seriesOfName("/imu/x", topics), ["/imu.x"]);
  assert.deepEqual(seriesOfName("imu/x:z", topics), ["/imu.x", "/imu.z"]);
  assert.deepEqual(seriesOfName("/imu/pose/at/x:y", topics), ["/imu/pose.at.x", "/imu/pose.at.y"]);
  assert.deepEqual(seriesOfName("/count", topics), ["/count.data"]);
  assert.deepEqual(seriesOfName("/imu", topics), ["/imu.x", "/imu.y", "/imu.z"]);
});

test("a name waits for its topic", () => {
  assert.equal(seriesOfName("/later/data", topics), undefined);
  assert.equal(seriesOfName("", topics), undefined);
  assert.equal(seriesOfName("/imu", new Map()), undefined);
});

test("a typed name has slashes or dots, and may name an element of an array", () => {
  assert.deepEqual(seriesOfTyped(" /imu/pose/at/x", topics), ["/imu/pose.at.x"]);
  assert.deepEqual(seriesOfTyped("/scan.ranges[3]", topics), ["/scan.ranges[3]"]);
  assert.deepEqual(seriesOfTyped("/count", topics), ["/count.data"]);
});

test("a typed name that is no number names nothing", () => {
  for (const each of ["/imu/w", "/imu/pose/at", "/scan/ranges", "/scan/ranges[", "/later/x", "/", ""])
    assert.deepEqual(seriesOfTyped(each, topics), []);
});
