// The limits that ROS 2's nodes declare for their parameters.
import assert from "node:assert/strict";
import { test } from "node:test";
import { byNode, limitsOf } from "../src/store/parameter_limits.ts";

const service = (name: string, type = "rcl_interfaces/DescribeParameters") => [name, { name, type }] as const;

test("parameters belong to the node with the longest name", () => {
  const services = new Map([
    service("/arm/describe_parameters"),
    service("/arm/hand/describe_parameters"),
    service("/other/describe_parameters", "std_srvs/Empty"),
  ]);
  const groups = byNode(["/arm/speed/max", "/arm/hand/grip", "/other/x", "/free"], services);
  assert.deepEqual(
    [...groups],
    [
      ["/arm", [{ full: "/arm/speed/max", name: "speed.max" }]],
      ["/arm/hand", [{ full: "/arm/hand/grip", name: "grip" }]],
    ],
  );
});

test("descriptors are limits", () => {
  assert.deepEqual(limitsOf({ read_only: true, description: "id" }), { isReadOnly: true, description: "id" });
  const range = { from_value: -2n, to_value: 7n, step: 1n };
  assert.deepEqual(limitsOf({ read_only: false, floating_point_range: [], integer_range: [range] }), {
    isReadOnly: false,
    description: "",
    min: -2,
    max: 7,
    step: 1,
  });
});
