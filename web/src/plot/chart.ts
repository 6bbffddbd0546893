// A chart of series over time, drawn by uPlot on a canvas.
import uPlot from "uplot";
import { formatNumber } from "../shell/format.ts";
import { color } from "../shell/theme.ts";
import { type Cell, cellsOf, gridOf, gridTimes } from "./columns.ts";
import type { Series } from "./series.ts";

export interface ChartOptions {
  /** Whether it is a small one without a time axis. */
  isSmall: boolean;
  /** The axis of a series; all series with the same axis share a scale. */
  axisOf: (series: Series) => string;
  /** The user chose a span of time. */
  onZoom?: (fromS: number, toS: number) => void;
  /** The user points at a time; undefined when the pointer leaves the chart. */
  onCursor?: (timeS: number | undefined) => void;
}

const COLORS = 8;
const MAX_AXES = 4;

/** The style variable of the color of the series at an index. */
export function seriesColor(index: number): string {
  return `--series-${(index % COLORS) + 1}`;
}

export class Chart {
  private readonly plot: uPlot;
  private readonly series: readonly Series[];
  private readonly host: HTMLElement;
  private readonly resize: ResizeObserver;

  constructor(host: HTMLElement, series: readonly Series[], options: ChartOptions) {
    this.host = host;
    this.series = series;
    this.plot = new uPlot(this.options(series, options), [[], ...series.map(() => [])], host);
    const canvas = this.plot.ctx.canvas;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", series.map((each) => each.id).join(", "));
    this.resize = new ResizeObserver(() => this.plot.setSize(sizeOf(host)));
    this.resize.observe(host);
  }

  /** Draws the series between two times. */
  draw(fromS: number, toS: number): void {
    const pixels = Math.round(this.plot.bbox.width / devicePixelRatio);
    if (pixels < 2) return;
    const grid = gridOf(fromS, toS, pixels);
    const data: [number[], ...Cell[][]] = [gridTimes(grid)];
    for (const each of this.series) data.push(cellsOf(each.buffer, grid, each.isStepped));
    this.plot.batch(() => {
      this.plot.setData(data as uPlot.AlignedData, false);
      this.plot.setScale("x", { min: fromS, max: toS });
    });
  }

  dispose(): void {
    this.resize.disconnect();
    this.plot.destroy();
  }

  private options(series: readonly Series[], options: ChartOptions): uPlot.Options {
    const text = color("--muted");
    const grid = { stroke: color("--border"), width: 1 };
    const font = "12px system-ui, sans-serif";
    const scaleKeys = [...new Set(series.map(options.axisOf))].slice(0, MAX_AXES);
    const keyOf = (each: Series) => {
      const key = options.axisOf(each);
      return scaleKeys.includes(key) ? key : scaleKeys.at(-1)!;
    };
    const scales: uPlot.Scales = { x: { time: true, auto: false } };
    const axes: uPlot.Axis[] = [
      {
        show: !options.isSmall,
        stroke: text,
        grid,
        ticks: { show: false },
        font,
        space: 90,
        values: clockTimes,
      },
    ];
    scaleKeys.forEach((key, index) => {
      const isFlags = series.every((each) => keyOf(each) !== key || each.isStepped);
      scales[key] = isFlags ? { auto: false, range: [-0.2, 1.2] } : { auto: true, range: paddedRange };
      axes.push({
        scale: key,
        side: index % 2 === 0 ? 3 : 1,
        stroke: text,
        // Only the first axis has a grid: the lines of several grids would be confusing.
        grid: index === 0 ? grid : { show: false },
        ticks: { show: false },
        font,
        gap: 6,
        space: options.isSmall ? 36 : 44,
        size: (_, values) => axisWidth(values),
        ...(isFlags ? { splits: [0, 1] } : {}),
        values: (_, splits) => splits.map((each) => formatNumber(each)),
      });
    });
    return {
      ...sizeOf(this.host),
      padding: [8, options.isSmall ? 4 : 28, options.isSmall ? 6 : 0, 0],
      scales,
      axes,
      legend: { show: false },
      cursor: {
        show: !options.isSmall,
        points: { show: false },
        drag: { x: true, y: false, setScale: false },
      },
      series: [
        {},
        ...series.map((each, index) => ({
          scale: keyOf(each),
          stroke: color(seriesColor(index)),
          width: 1.5,
          points: { show: false },
          ...(each.isStepped ? { paths: uPlot.paths.stepped!({ align: 1 }) } : {}),
        })),
      ],
      hooks: {
        setSelect: [
          (plot) => {
            const { left, width } = plot.select;
            if (width < 4) return;
            options.onZoom?.(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
            plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          },
        ],
        setCursor: [
          (plot) => {
            const left = plot.cursor.left ?? -1;
            options.onCursor?.(left >= 0 ? plot.posToVal(left, "x") : undefined);
          },
        ],
      },
    };
  }
}

function sizeOf(host: HTMLElement): { width: number; height: number } {
  return { width: Math.max(50, host.clientWidth), height: Math.max(50, host.clientHeight) };
}

/** A range a little larger than the data; a flat line is in its middle. */
function paddedRange(_: uPlot, low: number, high: number): uPlot.Range.MinMax {
  if (low === null || high === null || !Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  const span = high - low;
  // A line of zeros has an axis of whole numbers.
  const minMargin = Math.max(Math.abs(high), Math.abs(low)) * 0.02 || 1;
  const margin = span > minMargin ? span * 0.08 : minMargin;
  return [low - margin, high + margin];
}

function axisWidth(values: string[] | null): number {
  const longest = (values ?? []).reduce((length, each) => Math.max(length, each.length), 3);
  return 14 + longest * 7;
}

function clockTimes(_: uPlot, splits: number[], __: number, ___: number, increment: number): string[] {
  return splits.map((each) => {
    const date = new Date(each * 1000);
    const time = date.toLocaleTimeString("en-GB");
    return increment >= 1
      ? time
      : `${time}.${String(date.getMilliseconds())
          .padStart(3, "0")
          .slice(0, increment < 0.1 ? 3 : 1)}`;
  });
}
