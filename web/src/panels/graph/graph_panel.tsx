// The graph of nodes and topics, with publishers and subscribers.
import { type Signal, useComputed, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { formatRate } from "../../shell/format.ts";
import { EmptyState, SearchField } from "../../shell/parts.tsx";
import type { Topic } from "../../store/topics.ts";
import { texts } from "../../texts.ts";
import { useTick } from "../hooks.ts";
import { IMAGE_TYPES } from "../images/types.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { type Box, type Drawing, type Edge, layout, MAX_BOXES, MAX_LABEL, shortLabel } from "./layout.ts";

// The size of a box that a finger can tap, in pixels.
const FINGER = 44;
// The space around the drawing, in pixels: `.graph-scroll` in graph.css.
const PADDING = 12;
// Names in a smaller drawing cannot be read.
const SMALLEST_FIT = 0.75;
// The number that fits on a screen.
const MAX_RATES = 60;
const LARGE_TYPES: readonly string[] = [
  ...IMAGE_TYPES,
  "sensor_msgs/PointCloud2",
  "sensor_msgs/PointCloud",
  "nav_msgs/OccupancyGrid",
];

interface GraphSettings {
  filter?: string;
  plumbing?: boolean;
}

function GraphPanel({ context }: { context: PanelContext }) {
  const settings = context.settings as Signal<GraphSettings>;
  const { robot } = context;
  // Undefined: as much as fits into the width.
  const chosenZoom = useSignal<number | undefined>(undefined);
  const host = useRef<HTMLDivElement>(null);
  const widthPx = useSignal(Number.POSITIVE_INFINITY);
  useEffect(() => {
    const element = host.current!;
    const observer = new ResizeObserver(() => {
      widthPx.value = element.clientWidth - 2 * PADDING;
    });
    observer.observe(element);
    return () => observer.disconnect();
  }, []);
  const isTouched = matchMedia("(pointer: coarse)").matches;
  const drawing = useComputed(() =>
    layout(
      { publishers: robot.publishers.value, subscribers: robot.subscribers.value },
      settings.value.filter ?? "",
      settings.value.plumbing ?? false,
      robot.info.value?.metadata?.node,
      isTouched ? FINGER : undefined,
    ),
  ).value;
  useRates(context, drawing);
  const fitted = Math.max(SMALLEST_FIT, Math.min(1, widthPx.value / (drawing?.width || 1)));
  const zoom = chosenZoom.value ?? (isTouched ? 1 : fitted);
  const change = (to: GraphSettings) => {
    settings.value = { ...settings.value, ...to };
  };
  return (
    <div class="graph" ref={host}>
      <div class="toolbar">
        <SearchField
          value={settings.value.filter ?? ""}
          label={texts.graph.filter}
          onInput={(filter) => change({ filter })}
        />
        <label class="check">
          <input
            type="checkbox"
            checked={settings.value.plumbing ?? false}
            onChange={(event) => change({ plumbing: event.currentTarget.checked })}
          />
          {texts.graph.plumbing}
        </label>
        <span class="space" />
        <button
          type="button"
          class="button"
          aria-label={texts.graph.smaller}
          onClick={() => {
            chosenZoom.value = zoom / 1.25;
          }}
        >
          −
        </button>
        <button
          type="button"
          class="button"
          aria-label={texts.graph.larger}
          onClick={() => {
            chosenZoom.value = zoom * 1.25;
          }}
        >
          +
        </button>
      </div>
      {drawing === undefined && (
        <EmptyState icon="graph" title={texts.graph.tooMany(MAX_BOXES)} text={texts.graph.tooManyText} />
      )}
      {drawing !== undefined && drawing.boxes.length === 0 && (
        <EmptyState icon="graph" title={texts.graph.empty} text={texts.graph.emptyText} />
      )}
      {drawing !== undefined && drawing.boxes.length > 0 && (
        // biome-ignore lint/a11y/noNoninteractiveTabindex: keys scroll it.
        <div class="graph-scroll" tabIndex={0}>
          {/* biome-ignore lint/a11y/useSemanticElements: SVG has no group element for readers; "img" hides its buttons. */}
          <svg
            class="graph-drawing"
            role="group"
            aria-label={texts.panels.graph}
            width={drawing.width * zoom}
            height={drawing.height * zoom}
            viewBox={`0 0 ${drawing.width} ${drawing.height}`}
          >
            <title>{texts.panels.graph}</title>
            <defs>
              <marker
                id="arrow"
                viewBox="0 0 8 8"
                refX="8"
                refY="4"
                markerWidth="7"
                markerHeight="7"
                orient="auto"
              >
                <path d="M0 0 L8 4 L0 8 z" class="graph-arrow" />
              </marker>
            </defs>
            {drawing.edges.map((edge) => (
              <Arrow key={`${edge.from}>${edge.to}`} edge={edge} />
            ))}
            {drawing.boxes.map((box) => (
              <Item key={box.id} box={box} context={context} />
            ))}
          </svg>
        </div>
      )}
    </div>
  );
}

function Arrow({ edge }: { edge: Edge }) {
  const [first, ...others] = edge.points;
  let path = `M${first!.x.toFixed(1)} ${first!.y.toFixed(1)}`;
  let last = first!;
  for (const next of others) {
    // Level at each point, so that the parts join without a corner.
    const middle = ((last.x + next.x) / 2).toFixed(1);
    path += `C${middle} ${last.y.toFixed(1)} ${middle} ${next.y.toFixed(1)} ${next.x.toFixed(1)} ${next.y.toFixed(1)}`;
    last = next;
  }
  return <path d={path} class="graph-edge" marker-end="url(#arrow)" />;
}

function Item({ box, context }: { box: Box; context: PanelContext }) {
  const open = () => context.open("topics", { search: box.search });
  return (
    // biome-ignore lint/a11y/useSemanticElements: SVG has no button element.
    <g
      class={`graph-${box.kind}`}
      transform={`translate(${box.x - box.width / 2} ${box.y - box.height / 2})`}
      role="button"
      tabindex={0}
      onClick={open}
      onKeyDown={(event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        open();
      }}
    >
      <rect width={box.width} height={box.height} rx={box.kind === "node" ? box.height / 2 : 4} />
      <text x={box.width / 2} y={box.height / 2} text-anchor="middle" dominant-baseline="central">
        {shortLabel(box.label)}
      </text>
      {box.label.length > MAX_LABEL && <title>{box.label}</title>}
      {box.kind === "topic" && box.isOne && <Rate box={box} context={context} />}
    </g>
  );
}

/** Receives the topics that are drawn, for their rates; large messages are not worth their cost. */
function useRates(context: PanelContext, drawing: Drawing | undefined): void {
  const topics = context.robot.topics.value;
  const rated = (drawing?.boxes ?? [])
    .filter(({ kind, isOne, label }) => kind === "topic" && isOne && isLight(topics.get(label)))
    .map((box) => box.label)
    .slice(0, MAX_RATES);
  useEffect(() => {
    const subscriptions = rated.map((topic) => context.subscribe(topic));
    return () => {
      for (const each of subscriptions) each.close();
    };
  }, [rated.join()]);
}

function isLight(topic: Topic | undefined): boolean {
  return topic?.isPublished === true && !LARGE_TYPES.includes(topic.typeName);
}

function Rate({ box, context }: { box: Box; context: PanelContext }) {
  const now = useTick(context, 1000);
  const hertz = context.robot.feed(box.label).rate.hertz(now);
  if (hertz === 0) return null;
  return (
    <text x={box.width / 2} y={box.height + 11} text-anchor="middle" class="graph-rate">
      {formatRate(hertz)}
    </text>
  );
}

export default preactPanel(GraphPanel);
