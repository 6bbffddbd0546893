import type { Panel } from "../panel.ts";
import { isText } from "../setting_checks.ts";

export const parametersPanel: Panel = {
  id: "parameters",
  title: "parameters",
  icon: "parameters",
  settings: { search: isText },
  load: () => import("./parameters_panel.tsx"),
};
