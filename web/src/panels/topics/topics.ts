import type { Panel } from "../panel.ts";
import { isText } from "../setting_checks.ts";

export const topicsPanel: Panel = {
  id: "topics",
  title: "topics",
  icon: "topics",
  onTabBar: true,
  fillsPage: true,
  settings: { search: isText, topic: isText },
  load: () => import("./topics_panel.tsx"),
};
