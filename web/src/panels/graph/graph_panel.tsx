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
import { type Box, type Drawing, type Edge, layout, MAX_BOXES } from "./layout.ts";

// The size of a box that a finger can tap, in pixels.
const FINGER = 44;
// The space around the drawing, in pixels: `.graph-scroll` in graph.css.
const PADDING = 12;
// Names in a smaller drawing cannot be read.
const SMALLEST_FIT = 0.75;
// On a touch screen, the user can enlarge the drawing with two fingers.
const SMALLEST_TOUCH_FIT = 0.6;
// While the window is resized, the layout changes in steps, in pixels.
const WIDTH_STEP = 50;
const SMALLEST_ZOOM = 0.1;
const LARGEST_ZOOM = 4;
// The number of rates that fit on a screen.
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
  // Undefined: the drawing is fitted to the width.
  const chosenZoom = useSignal<number | undefined>(undefined);
  const host = useRef<HTMLDivElement>(null);
  const scroll = useRef<HTMLDivElement>(null);
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
  const smallest = isTouched ? SMALLEST_TOUCH_FIT : SMALLEST_FIT;
  const maxWidth = useComputed(() => (Math.floor(widthPx.value / WIDTH_STEP) * WIDTH_STEP) / smallest);
  const drawing = useComputed(() =>
    layout(
      { publishers: robot.publishers.value, subscribers: robot.subscribers.value },
      settings.value.filter ?? "",
      settings.value.plumbing ?? false,
      robot.info.value?.metadata?.node,
      isTouched ? FINGER : undefined,
      maxWidth.value,
    ),
  ).value;
  useRates(context, drawing);
  const fitted = Math.max(smallest, Math.min(1, widthPx.value / (drawing?.width || 1)));
  const zoom = chosenZoom.value ?? fitted;
  usePinch(host, scroll, zoom, (to) => {
    chosenZoom.value = Math.min(LARGEST_ZOOM, Math.max(SMALLEST_ZOOM, to));
  });
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
        <div class="graph-scroll" ref={scroll} tabIndex={0}>
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
              <Arrow key={`${edge.from}>${edge.to}`} edge={edge} isVertical={drawing.isVertical} />
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

/** Zooms with two fingers; the point between them stays there. */
function usePinch(
  host: { readonly current: HTMLDivElement | null },
  scroll: { readonly current: HTMLDivElement | null },
  zoom: number,
  change: (to: number) => void,
): void {
  const current = useRef({ zoom, change });
  current.current = { zoom, change };
  useEffect(() => {
    const panel = host.current!;
    let before = 0;
    const onTouch = (event: TouchEvent) => {
      const [one, two] = [event.touches[0], event.touches[1]];
      const element = scroll.current;
      if (one === undefined || two === undefined || element === null) {
        before = 0;
        return;
      }
      event.preventDefault();
      const distance = Math.hypot(one.clientX - two.clientX, one.clientY - two.clientY);
      if (before > 0 && distance > 0) {
        const { zoom, change } = current.current;
        const { left, top } = element.getBoundingClientRect();
        const x = (one.clientX + two.clientX) / 2 - left;
        const y = (one.clientY + two.clientY) / 2 - top;
        const point = [(element.scrollLeft + x) / zoom, (element.scrollTop + y) / zoom] as const;
        change((zoom * distance) / before);
        requestAnimationFrame(() => {
          element.scrollLeft = point[0] * current.current.zoom - x;
          element.scrollTop = point[1] * current.current.zoom - y;
        });
      }
      before = distance;
    };
    const kinds = ["touchstart", "touchmove", "touchend"] as const;
    for (const kind of kinds) panel.addEventListener(kind, onTouch, { passive: false });
    return () => {
      for (const kind of kinds) panel.removeEventListener(kind, onTouch);
    };
  }, []);
}

function Arrow({ edge, isVertical }: { edge: Edge; isVertical: boolean }) {
  const [first, ...others] = edge.points;
  let path = `M${first!.x.toFixed(1)} ${first!.y.toFixed(1)}`;
  let last = first!;
  for (const next of others) {
    // Level (or upright) at each point, so that the parts join without a corner.
    const [x, y] = [(last.x + next.x) / 2, (last.y + next.y) / 2];
    const bends = isVertical ? [last.x, y, next.x, y] : [x, last.y, x, next.y];
    path += `C${[...bends, next.x, next.y].map((each) => each.toFixed(1)).join(" ")}`;
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
        {box.text}
      </text>
      {box.text !== box.label && <title>{box.label}</title>}
      {box.kind === "topic" && box.isOne && <Rate box={box} context={context} />}
    </g>
  );
}

/** Receives the topics that are drawn, for their rates, except those with large messages, which cost too much. */
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
