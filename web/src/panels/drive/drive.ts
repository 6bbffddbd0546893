import type { Panel } from "../panel.ts";
import { DRIVE_TYPES } from "./commands.ts";

export const drivePanel: Panel = {
  id: "drive",
  title: "drive",
  icon: "drive",
  onTabBar: true,
  isUseful: ({ topics, subscribers }) =>
    [...topics.values()].some((each) => DRIVE_TYPES.includes(each.typeName) && subscribers.has(each.name)),
  load: () => import("./drive_panel.tsx"),
};
