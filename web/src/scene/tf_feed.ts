// Fills a tf buffer from /tf and /tf_static while a panel is visible.
import type { PanelContext } from "../panels/panel.ts";
import type { TransformStamped } from "./messages.ts";
import { normalized } from "./rigid.ts";
import { TfBuffer } from "./tf_buffer.ts";

export const TF_TYPES = ["tf2_msgs/TFMessage", "tf/tfMessage"];

/** Follow the frames; `onChange` runs after each message. The subscriptions end with the panel. */
export function followTf(context: PanelContext, onChange: () => void): TfBuffer {
  const tf = new TfBuffer();
  for (const topic of ["/tf", "/tf_static"]) {
    const { feed } = context.subscribe(topic, (arrival) => {
      const message = feed.lastMessage();
      if (message === undefined || message instanceof Error) return;
      for (const each of message.transforms as unknown as TransformStamped[]) {
        const { translation: t, rotation: r } = each.transform;
        tf.insert(
          each.header.frame_id,
          each.child_frame_id,
          each.header.stamp.sec + each.header.stamp.nsec * 1e-9,
          { translation: [t.x, t.y, t.z], rotation: normalized([r.x, r.y, r.z, r.w]) },
          topic === "/tf_static",
          arrival.receivedMs,
        );
      }
      onChange();
    });
  }
  return tf;
}

/** The frame that a person most likely means by "the world": REP 105's names, else the largest tree's root. */
export function likelyFixedFrame(tf: TfBuffer, otherwise: string): string {
  const frames = tf.frames();
  for (const name of ["map", "odom", "world", "base_footprint", "base_link"])
    if (frames.includes(name)) return tf.root(name) === name ? name : tf.root(name);
  const sizes = new Map<string, number>();
  for (const frame of frames) sizes.set(tf.root(frame), (sizes.get(tf.root(frame)) ?? 0) + 1);
  const roots = [...sizes].sort((a, b) => b[1] - a[1]);
  return roots[0]?.[0] ?? otherwise;
}
