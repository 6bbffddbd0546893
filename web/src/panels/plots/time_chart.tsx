// A chart that follows the robot's clock, or shows a fixed span of time.
import { effect, type ReadonlySignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Chart, type ChartOptions } from "../../plot/chart.ts";
import { type Series, seriesStore } from "../../plot/series.ts";
import { theme } from "../../shell/theme.ts";
import { frameTask } from "../../store/frames.ts";
import type { PanelContext } from "../panel.ts";

/** The shown time: the last seconds, or a fixed span. */
export type Span = { lastS: number } | { fromS: number; toS: number };

// A faster rate makes no visible difference for a line that moves slowly.
const DRAW_PERIOD_MS = 30;
const SMALL_DRAW_PERIOD_MS = 60;

interface Props {
  context: PanelContext;
  series: readonly Series[];
  span: ReadonlySignal<Span>;
  /** Changes when the axes do. */
  axesKey: string;
  options: ChartOptions;
}

export function TimeChart({ context, series, span, axesKey, options }: Props) {
  const host = useRef<HTMLDivElement>(null);
  const colors = theme.value;
  const units = series.map((each) => each.unit + each.isStepped).join();
  useEffect(() => {
    const chart = new Chart(host.current!, series, options);
    const { clock } = seriesStore(context.robot);
    const periodMs = options.isSmall ? SMALL_DRAW_PERIOD_MS : DRAW_PERIOD_MS;
    let drawnMs = Number.NEGATIVE_INFINITY;
    const task = frameTask(() => {
      const now = performance.now();
      const shown = span.peek();
      if ("lastS" in shown) {
        if (now - drawnMs >= periodMs) {
          drawnMs = now;
          const toS = clock.nowS();
          chart.draw(toS - spanOf(shown.lastS, series, toS), toS);
        }
        // The chart moves while it is visible.
        if (context.visible.peek()) task.markDirty();
      } else chart.draw(shown.fromS, shown.toS);
    });
    const stop = effect(() => {
      void span.value;
      if (context.visible.value) task.markDirty();
    });
    const resize = new ResizeObserver(() => task.markDirty());
    resize.observe(host.current!);
    return () => {
      resize.disconnect();
      stop();
      task.dispose();
      chart.dispose();
    };
  }, [series, colors, units, axesKey]);
  return <div class={options.isSmall ? "plots-chart small" : "plots-chart"} ref={host} />;
}

// A new chart shows a shorter time, so that it is not mostly empty.
const FIRST_SPAN_S = 5;

function spanOf(wantedS: number, series: readonly Series[], toS: number): number {
  const oldest = Math.min(...series.map(({ buffer }) => (buffer.length > 0 ? buffer.time(0) : toS)));
  return Math.min(wantedS, Math.max(FIRST_SPAN_S, toS - oldest));
}
