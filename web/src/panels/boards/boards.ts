import { texts } from "../../texts.ts";
import type { Panel } from "../panel.ts";

export const boardsPanel: Panel = {
  id: "boards",
  title: "boards",
  icon: "boards",
  onTabBar: true,
  // The card stays after the last report of a board, and shows its age.
  matches: ({ topics, hasBoards }) =>
    hasBoards || topics.get("/diagnostics")?.isPublished
      ? [{ key: "boards", title: texts.panels.boards, settings: {}, order: 0 }]
      : [],
  load: () => import("./boards_panel.tsx"),
};
