import type { Panel } from "../panel.ts";

export const SENSORS_TYPE = "sensing_platform/Sensors";

export const sensorsPanel: Panel = {
  id: "sensors",
  title: "sensors",
  icon: "sensors",
  fillsPage: true,
  isUseful: ({ topics }) => [...topics.values()].some((each) => each.typeName === SENSORS_TYPE),
  load: () => import("./sensors_panel.tsx"),
};
