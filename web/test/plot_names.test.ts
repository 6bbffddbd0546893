// Names as people type them for rqt_plot.
import assert from "node:assert/strict";
import { test } from "node:test";
import { seriesOfName } from "../src/plot/plot_names.ts";
import { Topic } from "../src/store/topics.ts";

const POINT = "float64 x\nfloat64 y\nfloat64 z";
const topics = new Map(
  [
    { name: "/imu", schemaName: "geometry_msgs/Point", schema: POINT },
    {
      name: "/imu/pose",
      schemaName: "test/Pose",
      schema: `geometry_msgs/Point at\n===\nMSG: geometry_msgs/Point\n${POINT}`,
    },
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
