// Small mesh files that would be large in memory.
import assert from "node:assert/strict";
import { test } from "node:test";
import { checkCollada, checkStl } from "../src/scene/mesh_limits.ts";

function stl(count: number, triangles: number): Uint8Array {
  const bytes = new Uint8Array(84 + 50 * triangles + 1);
  new DataView(bytes.buffer).setUint32(80, count, true);
  return bytes.subarray(0, -1);
}

function nodes(levels: number, last: string): string {
  const names = Array.from({ length: levels }, (_, level) => `n${level}`);
  const body = names.map((name, level) => {
    const url = level + 1 < levels ? `n${level + 1}` : last;
    return `<node id="${name}"><node><instance_node name="a" url="#${url}"/></node><instance_node url='#${url}'/></node>`;
  });
  return `<library_nodes>${body.join("")}</library_nodes><visual_scene><node><instance_node url="#n0"/></node></visual_scene>`;
}

test("an STL file has the triangles that it names", () => {
  checkStl(stl(2, 2));
  checkStl(new TextEncoder().encode("solid x\nendsolid x\n"));
  assert.throws(() => checkStl(stl(0xffffffff, 2)), /ends after 2 of 4294967295 triangles/);
  assert.throws(() => checkStl(new Uint8Array(10)), /no triangles/);
  const facet = "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n";
  checkStl(new TextEncoder().encode(`solid x\n${facet.repeat(1000)}endsolid x\n`.repeat(2)));
  const unended = [
    "solid ".repeat(3000),
    `solid ${"facet ".repeat(3000)}endsolid`,
    `solid ${facet.repeat(1000)}`,
  ];
  for (const text of unended)
    assert.throws(() => checkStl(new TextEncoder().encode(text)), /has no end/, text.slice(0, 20));
});

test("nodes of a Collada file that double at each level are refused", () => {
  checkCollada(nodes(10, ""));
  assert.throws(() => checkCollada(nodes(40, "")), /more than 100000 nodes/);
  assert.throws(() => checkCollada(nodes(2, "n0")), /more than 100000 nodes/);
  assert.throws(() => checkCollada("<node>".repeat(200)), /more than 100 levels/);
  const began = process.cpuUsage();
  for (const start of ["<node ", "<instance_node "]) checkCollada(start.repeat(20_000));
  // A search to the end of the file for each start of a tag would take ten seconds.
  assert.ok(process.cpuUsage(began).user < 1_000_000);
});
