import type { Panel } from "../panel.ts";
import { isText } from "../setting_checks.ts";
import { simulatedBoards } from "./board_state.ts";

export const simulationPanel: Panel = {
  id: "simulation",
  title: "simulation",
  icon: "simulation",
  isUseful: ({ topics }) => simulatedBoards(topics.values()).size > 0,
  matches: ({ topics }) =>
    [...simulatedBoards(topics.values())].map(([topic, name]) => ({
      key: topic,
      title: name,
      settings: { topic },
      order: 15,
    })),
  settings: { topic: isText },
  load: () => import("./simulation_panel.tsx"),
};
