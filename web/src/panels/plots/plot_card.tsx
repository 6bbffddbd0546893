// A plot as a card of the overview: the current values, and their history.
import { useSignal } from "@preact/signals";
import type { Series } from "../../plot/series.ts";
import { formatFixed } from "../../shell/format.ts";
import { texts } from "../../texts.ts";
import { useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { type Span, TimeChart } from "./time_chart.tsx";
import { axisKey, useSeries } from "./use_series.ts";

const CARD_SPAN_S = 30;
const VALUE_PERIOD_MS = 200;

export function PlotCard({ context, ids }: { context: PanelContext; ids: readonly string[] }) {
  const series = useSeries(context, ids);
  const span = useSignal<Span>({ lastS: CARD_SPAN_S });
  return (
    <div class="plots-card">
      <Values context={context} series={series} />
      <TimeChart
        context={context}
        series={series}
        span={span}
        axesKey=""
        options={{ isSmall: true, axisOf: (each) => axisKey(each) }}
      />
    </div>
  );
}

function Values({ context, series }: { context: PanelContext; series: readonly Series[] }) {
  const now = useTick(context, VALUE_PERIOD_MS);
  // The first value is shown immediately.
  for (const each of series)
    if (each.buffer.length === 0) void context.robot.feed(each.topicName).version.value;
  const names = shortNames(series);
  const units = new Set(series.map((each) => each.unit));
  const isUnitAt = (index: number) => units.size > 1 || index === series.length - 1;
  return (
    <div class="plots-values">
      {series.map((each, index) => {
        const feed = context.robot.feed(each.topicName);
        const isFresh = each.buffer.length > 0 && !feed.isStale(now);
        return (
          <div key={each.id} class={isFresh ? "plots-value" : "plots-value stale"}>
            {series.length > 1 && <span class={`plots-name series-${(index % 8) + 1}`}>{names[index]}</span>}
            <span class="plots-number">
              {valueText(each)}
              {each.unit && isUnitAt(index) && <span class="plots-unit"> {each.unit}</span>}
            </span>
          </div>
        );
      })}
    </div>
  );
}

export function valueText(series: Series, value = series.buffer.lastValue): string {
  if (series.error) return "?";
  if (Number.isNaN(value)) return "–";
  if (series.isStepped) return value ? texts.plots.on : texts.plots.off;
  return formatFixed(value);
}

/** The end of each path that differs from the others. */
function shortNames(series: readonly Series[]): string[] {
  const parts = series.map((each) => each.path.split("."));
  for (let length = 1; length < 6; length++) {
    const names = parts.map((each) => each.slice(-length).join("."));
    if (new Set(names).size === names.length) return names;
  }
  return series.map((each) => each.path);
}
