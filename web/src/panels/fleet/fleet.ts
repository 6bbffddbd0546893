import { texts } from "../../texts.ts";
import type { Panel } from "../panel.ts";
import { FLEET_TYPE } from "./fleet_messages.ts";

export const fleetPanel: Panel = {
  id: "fleet",
  title: "fleet",
  icon: "fleet",
  isUseful: ({ topics }) => [...topics.values()].some((each) => each.typeName === FLEET_TYPE),
  matches: ({ topics }) =>
    [...topics.values()].some((each) => each.typeName === FLEET_TYPE && each.channelId !== undefined)
      ? [{ key: "fleet", title: texts.panels.fleet, settings: {}, order: 5 }]
      : [],
  load: () => import("./fleet_panel.tsx"),
};
