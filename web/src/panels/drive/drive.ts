import type { Panel } from "../panel.ts";
import { drivableTopics } from "./drivable.ts";

export const drivePanel: Panel = {
  id: "drive",
  title: "drive",
  icon: "drive",
  onTabBar: true,
  isUseful: (graph) => drivableTopics(graph).length > 0,
  load: () => import("./drive_panel.tsx"),
};
