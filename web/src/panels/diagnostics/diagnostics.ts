import type { Panel } from "../panel.ts";

export const diagnosticsPanel: Panel = {
  id: "diagnostics",
  title: "diagnostics",
  icon: "diagnostics",
  isUseful: ({ topics }) => topics.has("/diagnostics"),
  load: () => import("./diagnostics_panel.tsx"),
};
