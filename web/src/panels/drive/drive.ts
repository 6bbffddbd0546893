import type { Panel } from "../panel.ts";
import { isByTopic, isText } from "../setting_checks.ts";
import { areLimits } from "./commands.ts";
import { drivableTopics } from "./drivable.ts";

export const drivePanel: Panel = {
  id: "drive",
  title: "drive",
  icon: "drive",
  onTabBar: true,
  isUseful: (graph) => drivableTopics(graph).length > 0,
  settings: { topic: isText, limits: isByTopic(areLimits) },
  load: () => import("./drive_panel.tsx"),
};
