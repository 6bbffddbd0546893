import type { Panel } from "../panel.ts";
import { isFlag, isText } from "../setting_checks.ts";

export const servicesPanel: Panel = {
  id: "services",
  title: "services",
  icon: "services",
  fillsPage: true,
  settings: { service: isText, search: isText, plumbing: isFlag },
  load: () => import("./services_panel.tsx"),
};
