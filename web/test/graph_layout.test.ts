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

test("subscriptions of the page are drawn only with the plumbing", () => {
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
  assert.equal(shortLabel(name, 36).length, 35);
  assert.match(shortLabel(name, 36), /^\/robot\/x+…x+\/position$/);
});

test("on a phone, a chain goes down, and a node with many topics goes to the right", () => {
  const chain = new Map<string, string[]>();
  const readers = new Map<string, string[]>();
  for (let i = 0; i < 6; i++) {
    chain.set(`/topic${i}`, [`/node${i}`]);
    readers.set(`/topic${i}`, [`/node${i + 1}`]);
  }
  const star = new Map(Array.from({ length: 12 }, (_, i) => [`/topic${i}`, ["/a"]]));
  const down = layout({ publishers: chain, subscribers: readers }, "", false, "", 44, 600)!;
  const right = layout({ publishers: star, subscribers: new Map() }, "", false, "", 44, 600)!;
  assert.deepEqual([down.isVertical, right.isVertical], [true, false]);
  // In a window, the usual direction if it fits.
  for (const [width, isVertical] of [
    [1000, true],
    [3000, false],
  ] as const)
    assert.equal(
      layout({ publishers: chain, subscribers: readers }, "", false, "", 30, width)?.isVertical,
      isVertical,
    );
  assert.ok(Math.max(down.width, right.width) <= 366);
  for (const { from, to, points } of down.edges) {
    const box = (id: string) => down.boxes.find((each) => each.id === id)!;
    assert.deepEqual(points[0], { x: box(from).x, y: box(from).y + box(from).height / 2 });
    assert.deepEqual(points.at(-1), { x: box(to).x, y: box(to).y - box(to).height / 2 });
  }
});
