// The contract between a panel and the page. README.md explains how to add one.
import type { ReadonlySignal, Signal } from "@preact/signals";
import type { IconName } from "../shell/icons.tsx";
import type { Feed, Listener } from "../store/feed.ts";
import type { Robot } from "../store/robot.ts";
import type { Topic } from "../store/topics.ts";
import type { texts } from "../texts.ts";
import type { SettingChecks, Settings } from "./setting_checks.ts";

/** A card that a panel offers for the overview. */
export interface Suggestion {
  /** Stable, so that the card keeps its position: `/ultrasound`. */
  key: string;
  /** The text of the card's header. */
  title: string;
  settings: Settings;
  /** Columns of the overview's grid on a wide screen, 1 to 3. */
  width?: 1 | 2 | 3;
  /** Smaller comes first: boards 0, controls 10, images 20, plots 30, others 40 and more. */
  order: number;
}

export interface Graph {
  topics: ReadonlyMap<string, Topic>;
  publishers: ReadonlyMap<string, readonly string[]>;
  subscribers: ReadonlyMap<string, readonly string[]>;
  services: ReadonlyMap<string, { name: string; type: string }>;
  /** The gateway's nodes, which publish and subscribe for pages. */
  ownNodes: readonly string[];
  /** Whether a board has reported since the page was opened. */
  hasBoards: boolean;
}

export interface PanelContext {
  robot: Robot;
  /** The settings of this instance; assigning a new object saves it. */
  settings: Signal<Settings>;
  /** Whether a part of the panel is on the screen and the page is not hidden. */
  visible: ReadonlySignal<boolean>;
  /** Whether it is a card of the overview, so that it shows less. */
  isCard: boolean;
  /**
   * Receives a topic while the panel is visible, until the returned function is called or the panel is disposed.
   * `listener` gets every message; without it, read `feed.version.value` and `feed.lastMessage()`. With `withLatched`
   * it also gets the latched messages of several publishers that another panel has just received.
   */
  subscribe(topicName: string, listener?: Listener, withLatched?: boolean): { feed: Feed; close(): void };
  /** Opens another panel's page, such as `open("topics", { search: "/imu" })`. */
  open(panelId: string, settings?: Settings): void;
}

/** The `default` export of a panel's module. */
export interface PanelModule {
  /** Builds the panel in `host`; returns a function that removes it and frees its resources. */
  mount(host: HTMLElement, context: PanelContext): () => void;
}

export interface Panel {
  /** The name in addresses: `#/topics`. */
  id: string;
  title: keyof typeof texts.panels;
  icon: IconName;
  /** Whether it is one of the four in the phone's tab bar; the others are under "More". */
  onTabBar?: boolean;
  /** Whether its page fills the whole window, without a scroll bar. */
  fillsPage?: boolean;
  /** The check of each of its settings; without it, the panel has none. */
  settings?: SettingChecks;
  /** Names of settings that its cards share with its page; the values are by topic. */
  shared?: readonly string[];
  /** Whether its code is large: as a card it is loaded when the others have drawn. */
  loadsLate?: boolean;
  /** Whether the navigation offers it on this graph; without it, always. */
  isUseful?(graph: Graph): boolean;
  /** The cards that it offers for the overview. Called when the graph changes, so it must be fast. */
  matches?(graph: Graph): Suggestion[];
  /** Loads the panel's code on first use: `() => import("./topics/topics_panel.tsx")`. */
  load(): Promise<{ default: PanelModule }>;
}
