import type { Panel } from "../panel.ts";

export const recordingPanel: Panel = {
  id: "recording",
  title: "recording",
  icon: "recording",
  load: () => import("./recording_panel.tsx"),
};
