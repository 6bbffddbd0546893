// Nodes and topics, and who publishes what for whom.
import { type Signal, useComputed, useSignal } from "@preact/signals";
import { formatRate } from "../../shell/format.ts";
import { EmptyState, SearchField } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { type Box, type Edge, layout, MAX_BOXES } from "./layout.ts";

interface GraphSettings {
  filter?: string;
  plumbing?: boolean;
}

function GraphPanel({ context }: { context: PanelContext }) {
  const settings = context.settings as Signal<GraphSettings>;
  const { robot } = context;
  const zoom = useSignal(1);
  const drawing = useComputed(() =>
    layout(
      { publishers: robot.publishers.value, subscribers: robot.subscribers.value },
      settings.value.filter ?? "",
      settings.value.plumbing ?? false,
    ),
  ).value;
  const change = (to: GraphSettings) => {
    settings.value = { ...settings.value, ...to };
  };
  return (
    <div class="graph">
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
            zoom.value /= 1.25;
          }}
        >
          −
        </button>
        <button
          type="button"
          class="button"
          aria-label={texts.graph.larger}
          onClick={() => {
            zoom.value *= 1.25;
          }}
        >
          +
        </button>
      </div>
      {drawing === undefined && <p class="empty-line">{texts.graph.tooMany(MAX_BOXES)}</p>}
      {drawing !== undefined && drawing.boxes.length === 0 && (
        <EmptyState icon="graph" title={texts.graph.empty} text={texts.graph.emptyText} />
      )}
      {drawing !== undefined && drawing.boxes.length > 0 && (
        <div class="graph-scroll">
          <svg
            class="graph-drawing"
            role="img"
            aria-label={texts.panels.graph}
            width={drawing.width * zoom.value}
            height={drawing.height * zoom.value}
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
  const path = edge.points
    .map(({ x, y }, i) => `${i === 0 ? "M" : "L"}${x.toFixed(1)} ${y.toFixed(1)}`)
    .join(" ");
  return <path d={path} class="graph-edge" marker-end="url(#arrow)" />;
}

function Item({ box, context }: { box: Box; context: PanelContext }) {
  const open = () => context.open("topics", { search: box.label });
  return (
    // biome-ignore lint/a11y/useSemanticElements: SVG has no button element.
    <g
      class={`graph-${box.kind}`}
      transform={`translate(${box.x - box.width / 2} ${box.y - box.height / 2})`}
      role="button"
      tabIndex={0}
      onClick={open}
      onKeyDown={(event) => {
        if (event.key === "Enter") open();
      }}
    >
      <rect width={box.width} height={box.height} rx={box.kind === "node" ? 15 : 4} />
      <text x={box.width / 2} y={box.height / 2} text-anchor="middle" dominant-baseline="central">
        {box.label}
      </text>
      {box.kind === "topic" && <Rate box={box} context={context} />}
    </g>
  );
}

/** Topics that some panel receives show their rate; the graph itself subscribes nothing. */
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
