import { texts } from "../../texts.ts";
import type { Panel } from "../panel.ts";

export const FIX_TYPE = "sensor_msgs/NavSatFix";

export const mapPanel: Panel = {
  id: "map",
  title: "map",
  icon: "map",
  fillsPage: true,
  isUseful: ({ topics }) => [...topics.values()].some((each) => each.typeName === FIX_TYPE),
  matches: ({ topics }) =>
    [...topics.values()].some((each) => each.typeName === FIX_TYPE && each.channelId !== undefined)
      ? [{ key: "map", title: texts.panels.map, settings: {}, width: 2, order: 40 }]
      : [],
  load: () => import("./map_panel.tsx"),
};
