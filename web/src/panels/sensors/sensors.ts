import type { Panel } from "../panel.ts";
import { isText, isTexts } from "../setting_checks.ts";
import { SENSORS_TYPE } from "./sensor_tree.ts";

export const sensorsPanel: Panel = {
  id: "sensors",
  title: "sensors",
  icon: "sensors",
  fillsPage: true,
  isUseful: ({ topics }) => [...topics.values()].some((each) => each.typeName === SENSORS_TYPE),
  settings: { search: isText, chosen: isTexts, folded: isTexts },
  load: () => import("./sensors_panel.tsx"),
};
