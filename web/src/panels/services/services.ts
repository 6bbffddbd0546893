import type { Panel } from "../panel.ts";

export const servicesPanel: Panel = {
  id: "services",
  title: "services",
  icon: "services",
  fillsPage: true,
  load: () => import("./services_panel.tsx"),
};
