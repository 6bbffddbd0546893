import type { Panel } from "../panel.ts";
import { isFlag, isText } from "../setting_checks.ts";

export const graphPanel: Panel = {
  id: "graph",
  title: "graph",
  icon: "graph",
  fillsPage: true,
  settings: { filter: isText, plumbing: isFlag },
  load: () => import("./graph_panel.tsx"),
};
