import { texts } from "../../texts.ts";
import type { Panel } from "../panel.ts";

export const boardsPanel: Panel = {
  id: "boards",
  title: "boards",
  icon: "boards",
  onTabBar: true,
  // The card stays when the last board is gone: it shows how long ago that was.
  matches: ({ topics, hasBoards }) =>
    hasBoards || topics.get("/diagnostics")?.isPublished
      ? [{ key: "boards", title: texts.panels.boards, settings: {}, order: 0 }]
      : [],
  load: () => import("./boards_panel.tsx"),
};
