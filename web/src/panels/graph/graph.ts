import type { Panel } from "../panel.ts";

export const graphPanel: Panel = {
  id: "graph",
  title: "graph",
  icon: "graph",
  fillsPage: true,
  load: () => import("./graph_panel.tsx"),
};
