import type { Panel } from "../panel.ts";
import { simulatedBoards } from "./board_state.ts";

export const simulationPanel: Panel = {
  id: "simulation",
  title: "simulation",
  icon: "simulation",
  isUseful: ({ topics }) => simulatedBoards(topics.values()).size > 0,
  load: () => import("./simulation_panel.tsx"),
};
