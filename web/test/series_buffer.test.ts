import assert from "node:assert/strict";
import { test } from "node:test";
import { cellsOf, gridOf, gridTimes } from "../src/plot/columns.ts";
import { KEPT_S, SeriesBuffer } from "../src/plot/series_buffer.ts";

function filled(count: number, periodS: number, startS = 1000): SeriesBuffer {
  const buffer = new SeriesBuffer();
  for (let index = 0; index < count; index++) buffer.push(startS + index * periodS, index);
  return buffer;
}

test("at most five minutes are kept", () => {
  const buffer = filled(100_000, 0.02);
  assert.equal(buffer.length, KEPT_S / 0.02 + 1);
  assert.equal(buffer.lastValue, 99_999);
  assert.ok(buffer.lastTime - buffer.time(0) <= KEPT_S);
});

test("memory is bounded whatever the rate", () => {
  const buffer = filled(1_100_000, 1e-5);
  assert.equal(buffer.length, 1 << 19);
  assert.equal(buffer.lastValue, 1_099_999);
});

test("a pause of a regular series is a gap", () => {
  const buffer = filled(100, 0.05);
  buffer.push(1000 + 99 * 0.05 + 3, 7);
  assert.ok(Number.isNaN(buffer.value(100)));
  assert.equal(buffer.value(101), 7);
});

test("a slow series has no gaps, unless it was interrupted", () => {
  const buffer = filled(5, 10);
  buffer.push(1000 + 90, 7);
  assert.equal(buffer.length, 6);
  buffer.interrupt();
  buffer.push(1000 + 150, 8);
  assert.ok(Number.isNaN(buffer.value(6)));
});

test("a series begins again when the clock is set back", () => {
  const buffer = filled(10, 1);
  buffer.push(500, 1);
  assert.equal(buffer.length, 1);
});

test("columns keep the least and the greatest value", () => {
  const buffer = new SeriesBuffer();
  for (let index = 0; index < 10_000; index++)
    buffer.push(index / 100, index === 5000 ? 50 : Math.sin(index));
  const grid = gridOf(0, 100, 200);
  const cells = cellsOf(buffer, grid, false);
  assert.equal(gridTimes(grid).length, cells.length);
  assert.equal(Math.max(...cells.map((each) => each ?? 0)), 50);
});

test("a gap breaks the line up to the next value", () => {
  const buffer = filled(100, 0.05, 0);
  buffer.push(30, 1);
  const grid = gridOf(0, 40, 400);
  const cells = cellsOf(buffer, grid, false);
  const times = gridTimes(grid);
  const broken = times.filter((_, index) => cells[index] === null);
  assert.ok(broken[0]! < 5.2 && broken.at(-1)! > 29.8, `${broken[0]} to ${broken.at(-1)}`);
  assert.equal(broken.length, cells.lastIndexOf(null) - cells.indexOf(null) + 1);
});

test("values that are not finite break the line and do not affect the scale", () => {
  const buffer = new SeriesBuffer();
  const values = [1, 2, Number.POSITIVE_INFINITY, 3, Number.NEGATIVE_INFINITY, 1e308];
  for (const [second, value] of values.entries()) buffer.push(second / 10, value);
  const cells = cellsOf(buffer, gridOf(0, 0.6, 60), false);
  const drawn = cells.filter((each) => typeof each === "number");
  assert.deepEqual([...new Set(drawn)], [1, 2, 3, 1e30]);
  assert.ok(cells.includes(null));
});

test("a window that begins within a gap begins without a line", () => {
  const buffer = filled(100, 0.05, 0);
  buffer.push(30, 1);
  assert.equal(cellsOf(buffer, gridOf(10, 40, 400), false)[0], null);
});

test("a window between two values shows the line between them", () => {
  const buffer = filled(3, 10, 0);
  assert.equal(cellsOf(buffer, gridOf(2, 18, 100), false)[0], 0.2);
  assert.equal(cellsOf(buffer, gridOf(2, 18, 100), true)[0], 0);
});

test("grids of windows that move share their columns", () => {
  const first = new Set(
    gridTimes(gridOf(1000, 1030, 300))
      .slice(2, -2)
      .map((each) => each.toFixed(6)),
  );
  const moved = gridTimes(gridOf(1000.33, 1030.33, 300)).slice(3, 100);
  assert.ok(moved.every((each) => first.has(each.toFixed(6))));
});
