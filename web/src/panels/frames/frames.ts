import type { Panel } from "../panel.ts";

export const framesPanel: Panel = {
  id: "frames",
  title: "frames",
  icon: "frames",
  isUseful: ({ topics }) => topics.has("/tf") || topics.has("/tf_static"),
  load: () => import("./frames_panel.tsx"),
};
