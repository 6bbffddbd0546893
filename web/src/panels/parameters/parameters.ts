import type { Panel } from "../panel.ts";

export const parametersPanel: Panel = {
  id: "parameters",
  title: "parameters",
  icon: "parameters",
  load: () => import("./parameters_panel.tsx"),
};
