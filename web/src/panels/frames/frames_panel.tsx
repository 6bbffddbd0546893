// The tree of tf frames: parent, age, rate and where each is.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { eulerDegrees } from "../../scene/rigid.ts";
import type { Edge, TfBuffer } from "../../scene/tf_buffer.ts";
import { followTf } from "../../scene/tf_feed.ts";
import { formatDuration, formatNumber, formatRate } from "../../shell/format.ts";
import { EmptyState } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";

// A moving frame that is older than this no longer moves.
const OLD_MS = 1000;

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
  if (edges.length === 0)
    return <EmptyState icon="frames" title={texts.frames.none} text={texts.frames.noneText} />;
  const children = new Map<string, Edge[]>();
  for (const edge of edges) {
    const list = children.get(edge.parent) ?? [];
    list.push(edge);
    children.set(edge.parent, list);
  }
  const roots = [...children.keys()].filter((frame) => !tf.current?.edges.has(frame)).sort();
  return (
    <div class="frames">
      {roots.map((root) => (
        <ul class="tree" key={root}>
          <li>
            <span class="frame-name">{root}</span>
            <Below frame={root} table={children} />
          </li>
        </ul>
      ))}
    </div>
  );
}

function Below({ frame, table }: { frame: string; table: Map<string, Edge[]> }) {
  const edges = table.get(frame);
  if (edges === undefined) return null;
  const sorted = [...edges].sort((a, b) => (a.child < b.child ? -1 : 1));
  return (
    <ul>
      {sorted.map((edge) => (
        <li key={edge.child}>
          <FrameRow edge={edge} />
          <Below frame={edge.child} table={table} />
        </li>
      ))}
    </ul>
  );
}

function FrameRow({ edge }: { edge: Edge }) {
  const newest = edge.samples.at(-1);
  const ageMs = performance.now() - edge.receivedMs;
  const isOld = !edge.isStatic && ageMs > OLD_MS;
  const [x, y, z] = newest?.transform.translation ?? [0, 0, 0];
  const [roll, pitch, yaw] = eulerDegrees(newest?.transform.rotation ?? [0, 0, 0, 1]);
  const number = (value: number) => formatNumber(Math.abs(value) < 1e-6 ? 0 : value, 3);
  return (
    <div class={isOld ? "frame stale" : "frame"}>
      <span class="frame-name">{edge.child}</span>
      <span class="number">{texts.frames.position(number(x), number(y), number(z))}</span>
      <span class="number">{texts.frames.rotation(number(roll), number(pitch), number(yaw))}</span>
      <span class="number">
        {edge.isStatic
          ? texts.frames.fixed
          : isOld
            ? texts.units.ago(formatDuration(ageMs / 1000))
            : formatRate(rateOf(edge))}
      </span>
    </div>
  );
}

function rateOf({ samples }: Edge): number {
  const recent = samples.slice(-20);
  const [first, last] = [recent[0], recent.at(-1)];
  if (first === undefined || last === undefined || last.timeS <= first.timeS) return 0;
  return (recent.length - 1) / (last.timeS - first.timeS);
}

export default preactPanel(FramesPanel);
