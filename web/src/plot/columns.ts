// Thins series to the resolution of the screen: the least and the greatest value of each pixel column.
import type { SeriesBuffer } from "./series_buffer.ts";

/** A line joins the values beside `undefined`; `null` breaks the line. */
export type Cell = number | null | undefined;

/** The columns' grid in time; it does not move with the window, so that lines do not flicker. */
export interface Grid {
  fromS: number;
  toS: number;
  firstColumn: number;
  stepS: number;
  columns: number;
}

export function gridOf(fromS: number, toS: number, pixels: number): Grid {
  const stepS = (toS - fromS) / Math.max(1, pixels);
  const firstColumn = Math.floor(fromS / stepS);
  return { fromS, toS, firstColumn, stepS, columns: Math.floor(toS / stepS) - firstColumn + 1 };
}

/** The times of a grid's cells: the left edge, then two for each column. */
export function gridTimes(grid: Grid): number[] {
  const times = [grid.fromS];
  for (let column = 0; column < grid.columns; column++) {
    const start = (grid.firstColumn + column) * grid.stepS;
    times.push(Math.max(grid.fromS, start + 0.25 * grid.stepS), start + 0.75 * grid.stepS);
  }
  return times;
}

// uPlot cannot draw an axis for larger values, and one such value must not hide the others.
const MAX_DRAWN = 1e30;

/** The drawn form of a value: NaN and infinite ones break the line (REP 117: nothing within range). */
export function drawable(value: number): number {
  return Number.isFinite(value) ? Math.max(-MAX_DRAWN, Math.min(MAX_DRAWN, value)) : Number.NaN;
}

/** The cells of a series on a grid. `isStepped`: between two values it has the earlier one. */
export function cellsOf(buffer: SeriesBuffer, grid: Grid, isStepped: boolean): Cell[] {
  const cells: Cell[] = new Array(1 + 2 * grid.columns).fill(undefined);
  const first = buffer.indexAt(grid.fromS);
  const end = buffer.length;
  // The cell after which the line is broken; all up to the next value are null, since uPlot joins undefined ones.
  let brokenAt = -1;
  if (first > 0 && first < end && Number.isNaN(drawable(buffer.value(first - 1)))) brokenAt = 0;
  else if (first > 0 && first < end) cells[0] = edgeValue(buffer, first, grid.fromS, isStepped);
  else if (first > 0 && isStepped) cells[0] = orBreak(drawable(buffer.value(end - 1)));
  const columnOf = (index: number) => Math.floor(buffer.time(index) / grid.stepS) - grid.firstColumn;
  let index = first;
  while (index < end) {
    const column = columnOf(index);
    if (column >= grid.columns) break;
    let low = Number.POSITIVE_INFINITY;
    let high = Number.NEGATIVE_INFINITY;
    let isLowFirst = true;
    let breaks = false;
    let last = Number.NaN;
    for (; index < end && columnOf(index) === column; index++) {
      const value = drawable(buffer.value(index));
      last = value;
      if (Number.isNaN(value)) {
        breaks = true;
        continue;
      }
      if (value < low) {
        low = value;
        isLowFirst = false;
      }
      if (value > high) {
        high = value;
        isLowFirst = true;
      }
    }
    const at = 1 + 2 * Math.max(0, column);
    if (low <= high) {
      if (brokenAt >= 0) cells.fill(null, brokenAt, at);
      brokenAt = -1;
      cells[at] = isLowFirst ? low : high;
      cells[at + 1] = isLowFirst ? high : low;
      if (isStepped && !Number.isNaN(last)) cells[at + 1] = last;
    }
    // A break after the column's last value is drawn; one between its values is too small to see.
    if (breaks && Number.isNaN(last)) brokenAt = low <= high ? at + 2 : at;
  }
  return cells;
}

function edgeValue(buffer: SeriesBuffer, next: number, atS: number, isStepped: boolean): Cell {
  const before = drawable(buffer.value(next - 1));
  const after = drawable(buffer.value(next));
  if (isStepped || Number.isNaN(before) || Number.isNaN(after)) return orBreak(before);
  const span = buffer.time(next) - buffer.time(next - 1);
  const share = span > 0 ? (atS - buffer.time(next - 1)) / span : 1;
  return before + (after - before) * share;
}

function orBreak(value: number): Cell {
  return Number.isNaN(value) ? null : value;
}
