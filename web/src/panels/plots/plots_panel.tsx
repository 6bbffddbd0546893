// Numbers over time: any path of any message, with several axes, pause, zoom, and five minutes of history.
import { useComputed, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { seriesOfName } from "../../plot/plot_names.ts";
import { type Series, seriesStore } from "../../plot/series.ts";
import { KEPT_S } from "../../plot/series_buffer.ts";
import { Icon } from "../../shell/icons.tsx";
import { pinCard } from "../../shell/layout_state.ts";
import { CopyButton, EmptyState, IconButton } from "../../shell/parts.tsx";
import { linkTo } from "../../shell/route.ts";
import { saveFile } from "../../shell/save_file.ts";
import { texts } from "../../texts.ts";
import { graphOf } from "../graph_of.ts";
import { useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { ArrayChart } from "./array_chart.tsx";
import { toCsv } from "./csv.ts";
import { toMcap } from "./mcap.ts";
import { PathPicker } from "./path_picker.tsx";
import { PlotCard, valueText } from "./plot_card.tsx";
import { plotSuggestions } from "./suggestions.ts";
import { type Span, TimeChart } from "./time_chart.tsx";
import { axisKey, useSeries } from "./use_series.ts";

const SPANS_S = [10, 30, 60, KEPT_S];
const DEFAULT_SPAN_S = 30;
// A chart with more lines is not readable.
const MAX_SERIES = 20;
const LEGEND_PERIOD_MS = 200;
const t = texts.plots;

function PlotsPanel({ context }: { context: PanelContext }) {
  const { settings } = context;
  const ids = strings(settings.value.series);
  return context.isCard ? <PlotCard context={context} ids={ids} /> : <PlotsPage context={context} />;
}

function strings(value: unknown): string[] {
  return Array.isArray(value) ? value.filter((each) => typeof each === "string").slice(0, MAX_SERIES) : [];
}

function PlotsPage({ context }: { context: PanelContext }) {
  const { settings, robot } = context;
  const change = (changes: object) => {
    settings.value = { ...settings.peek(), ...changes };
  };
  // Without a choice, the panel plots the first suggestion, and keeps it from its first value on: the graph
  // changes when a board is unplugged.
  const kept = useRef<string[]>([]);
  const suggested = useComputed(() => {
    const hasValues = kept.current.some((id) => robot.feed(id.slice(0, id.indexOf("."))).last !== undefined);
    if (!hasValues) kept.current = strings(plotSuggestions(graphOf(robot))[0]?.settings.series);
    return kept.current;
  });
  const isNamed = settings.value.series !== undefined || settings.value.names !== undefined;
  const ids = !isNamed ? suggested.value : strings(settings.value.series);
  const added = settings.value.add;
  useEffect(() => {
    if (typeof added !== "string") return;
    const own = strings(settings.peek().series);
    change({ add: undefined, series: own.includes(added) ? own : [...own, added].slice(-MAX_SERIES) });
  }, [added]);

  // A link names values as in rqt_plot; topics may appear later than the page.
  const names = strings(settings.value.names);
  const topics = robot.topics.value;
  useEffect(() => {
    if (names.length === 0) return;
    const found = names.map((each) => seriesOfName(each, topics));
    if (found.every((each) => each !== undefined)) {
      change({ names: undefined, series: found.flat().slice(0, MAX_SERIES) });
    }
  }, [names.join(), topics]);

  const series = useSeries(context, ids, true);
  const overTime = series.filter((each) => !each.isArray);
  const arrays = series.filter((each) => each.isArray);
  const spanS = SPANS_S.find((each) => each === settings.value.span) ?? DEFAULT_SPAN_S;
  const standing = useSignal<{ fromS: number; toS: number } | undefined>(undefined);
  const span = useComputed<Span>(() => {
    const chosen = SPANS_S.find((each) => each === settings.value.span) ?? DEFAULT_SPAN_S;
    return standing.value ?? { lastS: chosen };
  });
  const cursorS = useSignal<number | undefined>(undefined);
  const isPicking = useSignal(false);
  const own = new Set(strings(settings.value.ownAxes));
  const axisOf = (each: Series) => (own.has(each.id) ? each.id : axisKey(each));
  const toggle = (id: string) =>
    change({
      series: ids.includes(id) ? ids.filter((each) => each !== id) : [...ids, id].slice(-MAX_SERIES),
    });
  const shownSpan = () => {
    const now = seriesStore(robot).clock.nowS();
    return standing.peek() ?? { fromS: now - spanS, toS: now };
  };

  return (
    <div class="plots">
      <div class="toolbar">
        <button
          type="button"
          class="button plots-add"
          aria-label={t.add}
          aria-expanded={isPicking.value}
          onClick={() => {
            isPicking.value = !isPicking.value;
          }}
        >
          <Icon name="plus" size={18} /> <span>{t.add}</span>
        </button>
        <select
          class="field"
          aria-label={t.span}
          value={spanS}
          onChange={(event) => {
            standing.value = undefined;
            change({ span: Number(event.currentTarget.value) });
          }}
        >
          {SPANS_S.map((each) => (
            <option key={each} value={each}>
              {t.lastSpan(each)}
            </option>
          ))}
        </select>
        <IconButton
          icon={standing.value ? "play" : "pause"}
          label={standing.value ? t.live : texts.topics.pause}
          isPressed={standing.value !== undefined}
          onClick={() => {
            standing.value = standing.value ? undefined : shownSpan();
          }}
        />
        <span class="spring" />
        <IconButton
          icon="pin"
          label={t.pin}
          isDisabled={ids.length === 0}
          onClick={() => {
            pinCard({
              panelId: "plots",
              key: ids.join(),
              title: pinTitle(series),
              settings: { series: ids },
            });
            context.open("");
          }}
        />
        <IconButton
          icon="download"
          label={t.save}
          isDisabled={overTime.length === 0}
          onClick={() => {
            const { fromS, toS } = shownSpan();
            saveFile(`plot-${fileTime()}.csv`, toCsv(overTime, fromS, toS), "text/csv");
          }}
        />
        <IconButton
          icon="recording"
          label={t.saveMcap}
          isDisabled={overTime.length === 0}
          onClick={() => {
            const { fromS, toS } = shownSpan();
            const isRos2 = robot.info.value?.metadata?.recording_format === "mcap";
            const parts = toMcap(overTime, fromS, toS, isRos2);
            saveFile(`plot-${fileTime()}.mcap`, parts, "application/octet-stream");
          }}
        />
        <CopyButton
          text={`${location.origin}${location.pathname}${linkTo("plots", { ...settings.value, series: ids })}`}
          label={texts.shell.copyLink}
        />
      </div>
      {series.length === 0 ? (
        <EmptyState icon="plots" title={t.none} text={t.noneText} />
      ) : (
        <div class="plots-charts">
          {overTime.length > 0 && (
            <TimeChart
              context={context}
              series={overTime}
              span={span}
              axesKey={[...own].join()}
              options={{
                isSmall: false,
                axisOf,
                onZoom: (fromS, toS) => {
                  standing.value = { fromS, toS };
                },
                onCursor: (timeS) => {
                  cursorS.value = timeS;
                },
              }}
            />
          )}
          {arrays.map((each, index) => (
            <ArrayChart key={each.id} context={context} series={each} colorIndex={overTime.length + index} />
          ))}
          <Legend
            context={context}
            series={[...overTime, ...arrays]}
            cursorS={cursorS.value}
            own={own}
            onRemove={toggle}
            onOwnAxis={(id) => {
              if (!own.delete(id)) own.add(id);
              change({ ownAxes: [...own] });
            }}
          />
        </div>
      )}
      {isPicking.value && (
        <PathPicker
          context={context}
          chosen={ids}
          onToggle={toggle}
          onClose={() => {
            isPicking.value = false;
          }}
        />
      )}
    </div>
  );
}

interface LegendProps {
  context: PanelContext;
  series: readonly Series[];
  cursorS: number | undefined;
  own: ReadonlySet<string>;
  onRemove: (id: string) => void;
  onOwnAxis: (id: string) => void;
}

function Legend({ context, series, cursorS, own, onRemove, onOwnAxis }: LegendProps) {
  const now = useTick(context, LEGEND_PERIOD_MS);
  return (
    <ul class="plots-legend">
      {series.map((each, index) => {
        const isFresh = cursorS !== undefined || !context.robot.feed(each.topicName).isStale(now);
        return (
          <li key={each.id}>
            <span class={`plots-key series-${(index % 8) + 1}`} title={each.id}>
              <span class="plots-id">
                {each.path} <small>{each.topicName}</small>
              </span>
            </span>
            <span class={isFresh ? "plots-legend-value" : "plots-legend-value stale"}>
              {each.error ||
                (each.isArray ? texts.topics.elements(each.lastArray.length) : valueAt(each, cursorS))}
              {!each.error && !each.isArray && each.unit && ` ${each.unit}`}
            </span>
            {!each.isArray && series.length > 1 && (
              <IconButton
                icon="axis"
                label={t.ownAxis}
                isPressed={own.has(each.id)}
                onClick={() => onOwnAxis(each.id)}
              />
            )}
            <IconButton icon="close" label={t.remove} onClick={() => onRemove(each.id)} />
          </li>
        );
      })}
    </ul>
  );
}

function pinTitle(series: readonly Series[]): string {
  return [...new Set(series.map((each) => each.topicName))].join(", ");
}

function valueAt(series: Series, timeS: number | undefined): string {
  if (timeS === undefined) return valueText(series);
  const { buffer } = series;
  const next = buffer.indexAt(timeS);
  return next === 0 ? "–" : valueText(series, buffer.value(next - 1));
}

function fileTime(): string {
  return new Date().toISOString().slice(0, 19).replaceAll(":", "-");
}

export default preactPanel(PlotsPanel);
