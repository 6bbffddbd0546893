import { DISPLAY_TYPES } from "../../scene/display_types.ts";
import { texts } from "../../texts.ts";
import type { Panel } from "../panel.ts";
import { isText, isTexts } from "../setting_checks.ts";

const DRAWN = new Set<string>([...DISPLAY_TYPES, "tf2_msgs/TFMessage", "tf/tfMessage"]);

export const scenePanel: Panel = {
  id: "scene",
  title: "scene",
  icon: "scene",
  fillsPage: true,
  loadsLate: true,
  isUseful: ({ topics }) =>
    topics.has("/robot_description") || [...topics.values()].some((each) => DRAWN.has(each.typeName)),
  matches: ({ topics }) =>
    [...topics.values()].some((each) => DRAWN.has(each.typeName) && each.channelId !== undefined)
      ? [{ key: "scene", title: texts.panels.scene, settings: {}, width: 2, order: 25 }]
      : [],
  settings: { fixedFrame: isText, followedFrame: isText, hidden: isTexts, only: isTexts, rviz: isText },
  load: () => import("./scene_panel.tsx"),
};
