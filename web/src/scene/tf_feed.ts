// Fills a tf buffer from /tf and /tf_static while a panel is visible.
import type { PanelContext } from "../panels/panel.ts";
import type { Feed, Listener } from "../store/feed.ts";
import type { TransformStamped } from "./messages.ts";
import type { Quaternion, Vec3 } from "./rigid.ts";
import { MAX_FRAMES, TfBuffer } from "./tf_buffer.ts";

const STATIC_TOPIC = "/tf_static";

// Panels share one subscription, which receives each static transform once. A new panel starts with the earlier ones.
const staticTransforms = new WeakMap<Feed, Map<string, Received>>();

interface Received {
  readonly transform: TransformStamped;
  readonly receivedMs: number;
}

/** Follows the frames; `onChange` runs after each message. The subscriptions end with the panel. */
export function followTf(context: PanelContext, onChange: () => void): TfBuffer {
  const tf = new TfBuffer();
  for (const { transform, receivedMs } of staticsOf(context.robot.feed(STATIC_TOPIC)).values())
    insert(tf, transform, true, receivedMs);
  let beforeNs: bigint | undefined;
  for (const topic of ["/tf", STATIC_TOPIC]) {
    const listener: Listener = ({ receivedMs }) => {
      const nowNs = context.robot.simulatedTimeNs.peek();
      if (nowNs !== undefined && beforeNs !== undefined && nowNs < beforeNs) tf.clearHistory();
      beforeNs = nowNs;
      for (const each of lastTransforms(feed)) insert(tf, each, topic === STATIC_TOPIC, receivedMs);
      onChange();
    };
    const { feed } = context.subscribe(topic, listener, topic === STATIC_TOPIC);
  }
  return tf;
}

function staticsOf(feed: Feed): Map<string, Received> {
  const known = staticTransforms.get(feed) ?? new Map<string, Received>();
  if (staticTransforms.has(feed)) return known;
  staticTransforms.set(feed, known);
  feed.listeners.add(({ receivedMs }) => {
    for (const transform of lastTransforms(feed))
      if (known.size < MAX_FRAMES || known.has(transform.child_frame_id))
        known.set(transform.child_frame_id, { transform, receivedMs });
  });
  feed.topic.subscribe((topic) => {
    if (topic === undefined) known.clear();
  });
  return known;
}

function lastTransforms(feed: Feed): readonly TransformStamped[] {
  return (feed.lastValid()?.transforms ?? []) as unknown as TransformStamped[];
}

function insert(tf: TfBuffer, each: TransformStamped, isStatic: boolean, receivedMs: number): void {
  const { translation: t, rotation: r } = each.transform;
  const stampS = each.header.stamp.sec + each.header.stamp.nsec * 1e-9;
  const transform = {
    translation: [t.x, t.y, t.z] as Vec3,
    rotation: [r.x, r.y, r.z, r.w] as Quaternion,
  };
  tf.insert(each.header.frame_id, each.child_frame_id, stampS, transform, isStatic, receivedMs);
}

/** The most likely fixed frame: REP 105's names, else the largest tree's root. */
export function likelyFixedFrame(tf: TfBuffer, otherwise: string): string {
  const frames = tf.frames();
  for (const name of ["map", "odom", "world", "base_footprint", "base_link"])
    if (frames.includes(name)) return tf.root(name);
  const sizes = new Map<string, number>();
  for (const frame of frames) sizes.set(tf.root(frame), (sizes.get(tf.root(frame)) ?? 0) + 1);
  const roots = [...sizes].sort((a, b) => b[1] - a[1]);
  return roots[0]?.[0] ?? otherwise;
}
