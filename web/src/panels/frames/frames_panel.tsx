// The tree of tf frames, with the rate or age, the position and the rotation of each.
import { useSignal } from "@preact/signals";
import { Fragment } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { eulerDegrees } from "../../scene/rigid.ts";
import type { Edge, TfBuffer } from "../../scene/tf_buffer.ts";
import { followTf } from "../../scene/tf_feed.ts";
import { compareNames, formatDuration, formatRate } from "../../shell/format.ts";
import { EmptyState } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";

// A moving frame that is older than this no longer moves.
const OLD_MS = 1000;
const t = texts.frames;

function FramesPanel({ context }: { context: PanelContext }) {
  const tf = useRef<TfBuffer | undefined>(undefined);
  const version = useSignal(0);
  useEffect(() => {
    tf.current = followTf(context, () => {});
    version.value++;
  }, []);
  useTick(context, 500);
  void version.value;
  const edges = [...(tf.current?.edges.values() ?? [])];
  const problems = tf.current?.problems() ?? [];
  if (edges.length + problems.length === 0)
    return <EmptyState icon="frames" title={t.none} text={t.noneText} />;
  const children = new Map<string, Edge[]>();
  for (const edge of edges) {
    const list = children.get(edge.parent) ?? [];
    list.push(edge);
    children.set(edge.parent, list);
  }
  const roots = [...children.keys()].filter((frame) => !tf.current?.edges.has(frame)).sort();
  return (
    <div class="frames">
      {problems.map((each) => (
        <p key={each} class="problem">
          {each}
        </p>
      ))}
      <div class="frames-tree">
        <table>
          <thead>
            <tr>
              <th>{t.frame}</th>
              <th class="number rate">{t.rate}</th>
              <th class="number">{t.x}</th>
              <th class="number">{t.y}</th>
              <th class="number">{t.z}</th>
              <th class="number wide">{t.roll}</th>
              <th class="number wide">{t.pitch}</th>
              <th class="number wide">{t.yaw}</th>
            </tr>
          </thead>
          <tbody>
            {roots.map((root) => (
              <Fragment key={root}>
                <tr>
                  <td colSpan={8}>
                    <span class="frame-name root">{root}</span>
                  </td>
                </tr>
                <Below frame={root} table={children} depth={1} />
              </Fragment>
            ))}
          </tbody>
        </table>
      </div>
    </div>
  );
}

// A larger indent would leave no room for the names of deep frames.
const MAX_INDENT = 6;

function Below(props: { frame: string; table: Map<string, Edge[]>; depth: number }) {
  const { frame, table, depth } = props;
  const sorted = [...(table.get(frame) ?? [])].sort((a, b) => compareNames(a.child, b.child));
  return (
    <>
      {sorted.map((edge) => (
        <Fragment key={edge.child}>
          <FrameRow edge={edge} depth={Math.min(depth, MAX_INDENT)} />
          <Below frame={edge.child} table={table} depth={depth + 1} />
        </Fragment>
      ))}
    </>
  );
}

function FrameRow({ edge, depth }: { edge: Edge; depth: number }) {
  const newest = edge.samples.at(-1);
  const ageMs = performance.now() - edge.receivedMs;
  const isOld = !edge.isStatic && ageMs > OLD_MS;
  const position = newest?.transform.translation ?? [0, 0, 0];
  const angles = eulerDegrees(newest?.transform.rotation ?? [0, 0, 0, 1]);
  return (
    <tr class={isOld ? "stale" : undefined}>
      <td>
        <span class={`frame-name depth-${depth}`}>{edge.child}</span>
      </td>
      <td class="number rate muted">
        {edge.isStatic
          ? t.fixed
          : isOld
            ? texts.units.ago(formatDuration(ageMs / 1000))
            : formatRate(rateOf(edge))}
      </td>
      {[...position].map((meters, axis) => (
        <td key={axis} class="number">
          {withoutMinusZero(meters, 3)}
        </td>
      ))}
      {[...angles].map((degrees, axis) => (
        <td key={axis} class="number wide">
          {withoutMinusZero(degrees, 1)}
        </td>
      ))}
    </tr>
  );
}

/** A number with fixed digits: 0.0 instead of -0.0. */
function withoutMinusZero(value: number, digits: number): string {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text;
}

function rateOf({ samples }: Edge): number {
  const recent = samples.slice(-20);
  const [first, last] = [recent[0], recent.at(-1)];
  if (first === undefined || last === undefined || last.timeS <= first.timeS) return 0;
  return (recent.length - 1) / (last.timeS - first.timeS);
}

export default preactPanel(FramesPanel);
