import assert from "node:assert/strict";
import { test } from "node:test";
import { layout } from "../src/panels/graph/layout.ts";

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
