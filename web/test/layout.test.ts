import assert from "node:assert/strict";
import { test } from "node:test";
import { arranged, moved, NO_LAYOUT, readLayout, withCard, withoutCard } from "../src/shell/layout.ts";

const cards = ["a", "b", "c"].map((id) => ({ id }));
const ids = (shown: { id: string }[]) => shown.map((each) => each.id).join("");

test("without a layout the cards keep their order", () => {
  assert.equal(ids(arranged(cards, NO_LAYOUT)), "abc");
});

test("moved, hidden and new cards", () => {
  let layout = moved(NO_LAYOUT, cards, "c", -1);
  assert.equal(ids(arranged(cards, layout)), "acb");
  layout = withoutCard(layout, "a");
  assert.equal(ids(arranged(cards, layout)), "cb");
  assert.equal(ids(arranged([{ id: "n" }, ...cards], layout)), "cbn");
  assert.equal(moved(layout, arranged(cards, layout), "b", 1), layout);
});

test("an added card is shown once, and not after it is removed", () => {
  const card = { panelId: "plots", key: "x", title: "x", settings: {} };
  const layout = withCard(withCard(NO_LAYOUT, card), card);
  assert.equal(layout.added.length, 1);
  assert.deepEqual(withoutCard(layout, "plots x"), NO_LAYOUT);
});

test("the valid parts of damaged layouts are used", () => {
  const layout = readLayout({
    order: ["a", 5],
    widths: { a: 2, b: 9 },
    hidden: "a",
    added: [null, {}, { panelId: "p", key: "k", title: "t", settings: {} }],
  });
  assert.deepEqual(layout.order, ["a"]);
  assert.deepEqual(layout.widths, { a: 2 });
  assert.deepEqual(layout.hidden, []);
  assert.equal(layout.added.length, 1);
});
