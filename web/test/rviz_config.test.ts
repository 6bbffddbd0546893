import assert from "node:assert/strict";
import { test } from "node:test";
import { readRvizConfig } from "../src/scene/rviz_config.ts";

const ROS1 = `Panels:
  - Class: rviz/Displays
    Name: Displays
    Property Tree Widget:
      Expanded:
        - /Global Options1
      Splitter Ratio: 0.5
Visualization Manager:
  Class: ""
  Displays:
    - Alpha: 0.5
      Class: rviz/Grid
      Enabled: true
    - Class: rviz/LaserScan
      Enabled: false
      Topic: /scan
    - Class: rviz/Group
      Displays:
        - Class: rviz/Path
          Enabled: true
          Topic: /plan
      Enabled: true
    - Class: rviz/MarkerArray
      Enabled: true
      Marker Topic: markers
    - Class: rviz/Group
      Displays:
        - Class: rviz/Path
          Enabled: true
          Topic: /hidden
      Enabled: false
  Global Options:
    Background Color: 48; 48; 48
    Fixed Frame: map
`;

test("displays, topics and the fixed frame of RViz", () => {
  const config = readRvizConfig(ROS1);
  assert.equal(config.fixedFrame, "map");
  assert.deepEqual(
    config.displays.map(({ kind, enabled, topic }) => [kind, enabled, topic]),
    [
      ["Grid", true, ""],
      ["LaserScan", false, "/scan"],
      ["Path", true, "/plan"],
      ["Group", true, ""],
      ["MarkerArray", true, "/markers"],
      ["Group", false, ""],
    ],
  );
});

test("RViz2 nests its topics", () => {
  const config = readRvizConfig(`Visualization Manager:
  Displays:
    - Class: rviz_default_plugins/LaserScan
      Enabled: true
      Topic:
        Depth: 5
        Value: /scan
  Global Options:
    Fixed Frame: "odom"
`);
  assert.equal(config.fixedFrame, "odom");
  assert.deepEqual(config.displays, [{ kind: "LaserScan", enabled: true, topic: "/scan" }]);
});

test("other files are refused with a sentence", () => {
  for (const text of [
    "",
    "a: b",
    "<xml/>",
    "Visualization Manager:\n",
    `${"a:\n".repeat(30_000)}`,
    "\u0000\u0001",
  ]) {
    assert.throws(() => readRvizConfig(text), { name: "Error", message: /./ });
  }
});
