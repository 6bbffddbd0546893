import assert from "node:assert/strict";
import { test } from "node:test";
import { layout, shortLabel } from "../src/panels/graph/layout.ts";

test("five hundred topics of one node are one box", () => {
  const names = Array.from({ length: 500 }, (_, i) => `/many/t${i}`);
  const publishers = new Map(names.map((name) => [name, ["/a"]]));
  publishers.set("/other", ["/a", "/b"]);
  const drawing = layout({ publishers, subscribers: new Map([["/other", ["/c"]]]) }, "", false);
  assert.deepEqual(
    drawing?.boxes.map(({ label, search, isOne }) => [label, search, isOne]),
    [
      ["/a", "/a", true],
      ["/c", "/c", true],
      ["/b", "/b", true],
      ["/many/t… (500 topics)", "/many/t", false],
      ["/other", "/other", true],
    ],
  );
  assert.equal(drawing?.edges.length, 4);
});

test("a hundred topics of one node are one box each namespace", () => {
  const names = Array.from({ length: 100 }, (_, i) => `/${i % 2 ? "left" : "right"}/t${i}`);
  const publishers = new Map([...names, "/count", "/led"].map((name) => [name, ["/a"]]));
  const drawing = layout({ publishers, subscribers: new Map() }, "", false);
  assert.deepEqual(drawing?.boxes.map((each) => each.label).sort(), [
    "/a",
    "/count",
    "/led",
    "/left/t… (50 topics)",
    "/right/t… (50 topics)",
  ]);
});

test("what the page itself receives is drawn with the plumbing only", () => {
  const graph = {
    publishers: new Map([["/t", ["/a"]]]),
    subscribers: new Map([["/t", ["/page", "/b"]]]),
  };
  const nodes = (withPlumbing: boolean) =>
    layout(graph, "", withPlumbing, "/page")?.boxes.flatMap(({ kind, label }) =>
      kind === "node" ? [label] : [],
    );
  assert.deepEqual(nodes(false), ["/a", "/b"]);
  assert.deepEqual(nodes(true), ["/a", "/page", "/b"]);
});

test("edges leave and reach the middle of a side, and long names keep their ends", () => {
  const name = `/robot/${"x".repeat(60)}/position`;
  const drawing = layout(
    { publishers: new Map([[name, ["/a"]]]), subscribers: new Map([[name, ["/b"]]]) },
    "",
    false,
  );
  for (const { from, to, points } of drawing!.edges) {
    const box = (id: string) => drawing!.boxes.find((each) => each.id === id)!;
    assert.deepEqual(points[0], { x: box(from).x + box(from).width / 2, y: box(from).y });
    assert.deepEqual(points.at(-1), { x: box(to).x - box(to).width / 2, y: box(to).y });
  }
  assert.equal(shortLabel(name).length, 35);
  assert.match(shortLabel(name), /^\/robot\/x+…x+\/position$/);
});
