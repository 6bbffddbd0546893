import type { Panel } from "../panel.ts";

export const topicsPanel: Panel = {
  id: "topics",
  title: "topics",
  icon: "topics",
  onTabBar: true,
  fillsPage: true,
  load: () => import("./topics_panel.tsx"),
};
