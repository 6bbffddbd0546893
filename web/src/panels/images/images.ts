import type { Panel } from "../panel.ts";
import { hasFields, isByTopic, isFlag, isOneOf, isText } from "../setting_checks.ts";
import { IMAGE_TYPES } from "./types.ts";

export const imagesPanel: Panel = {
  id: "images",
  title: "images",
  icon: "images",
  isUseful: ({ topics }) => [...topics.values()].some((each) => IMAGE_TYPES.includes(each.typeName)),
  matches: ({ topics }) =>
    [...topics.values()]
      .filter((each) => IMAGE_TYPES.includes(each.typeName) && each.channelId !== undefined)
      .map(({ name }) => ({ key: name, title: name, settings: { topic: name }, order: 20 })),
  settings: {
    topic: isText,
    turns: isByTopic(hasFields({ quarters: isOneOf([0, 1, 2, 3]), mirrored: isFlag })),
  },
  shared: ["turns"],
  load: () => import("./images_panel.tsx"),
};
