// The numbers of an array against their index, as they are now.
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { seriesColor } from "../../plot/chart.ts";
import { drawable } from "../../plot/columns.ts";
import type { Series } from "../../plot/series.ts";
import { formatNumber } from "../../shell/format.ts";
import { color, theme } from "../../shell/theme.ts";
import { frameTask } from "../../store/frames.ts";
import type { PanelContext } from "../panel.ts";

interface Props {
  context: PanelContext;
  series: Series;
  colorIndex: number;
}

export function ArrayChart({ context, series, colorIndex }: Props) {
  const host = useRef<HTMLDivElement>(null);
  const colors = theme.value;
  useEffect(() => {
    const element = host.current!;
    const axis = {
      stroke: color("--muted"),
      grid: { stroke: color("--border"), width: 1 },
      ticks: { show: false },
      font: "12px system-ui, sans-serif",
      values: (_: uPlot, splits: number[]) => splits.map((each) => formatNumber(each)),
    };
    const size = () => ({
      width: Math.max(50, element.clientWidth),
      height: Math.max(50, element.clientHeight),
    });
    const plot = new uPlot(
      {
        ...size(),
        scales: { x: { time: false } },
        axes: [axis, { ...axis, size: 56 }],
        legend: { show: false },
        cursor: { show: false },
        series: [{}, { stroke: color(seriesColor(colorIndex)), width: 1.5 }],
      },
      [[], []],
      element,
    );
    plot.ctx.canvas.setAttribute("role", "img");
    plot.ctx.canvas.setAttribute("aria-label", series.id);
    let drawn: ArrayLike<number | bigint> | undefined;
    const task = frameTask(() => {
      const numbers = series.lastArray;
      if (numbers !== drawn) {
        drawn = numbers;
        const values = Array.from(numbers, (each) => {
          const value = drawable(Number(each));
          return Number.isNaN(value) ? null : value;
        });
        plot.setData([values.map((_, index) => index), values]);
      }
    });
    const subscription = context.subscribe(series.topicName, () => task.markDirty());
    task.markDirty();
    const resize = new ResizeObserver(() => plot.setSize(size()));
    resize.observe(element);
    return () => {
      resize.disconnect();
      subscription.close();
      task.dispose();
      plot.destroy();
    };
  }, [series, colors, colorIndex]);
  return <div class="plots-chart array" ref={host} />;
}
