// The overview's current layout: of the opened link, or else of the last visit.
import { effect, signal } from "@preact/signals";
import { loadSetting, saveSetting } from "../store/storage.ts";
import { type AddedCard, type Layout, NO_LAYOUT, readLayout, withCard } from "./layout.ts";
import { route } from "./route.ts";

const KEY = "overview";

export const layout = signal<Layout>(readLayout(loadSetting(KEY, {})));

// A link's layout is shown, and kept only when the user changes it.
effect(() => {
  const { panelId, settings } = route.value;
  if (panelId === "" && settings) layout.value = readLayout(settings);
});

export function changeLayout(changed: Layout): void {
  layout.value = changed;
  saveSetting(KEY, changed);
}

export function resetLayout(): void {
  changeLayout(NO_LAYOUT);
}

/** Adds a card to the overview, such as a plot that the user made. */
export function pinCard(card: AddedCard): void {
  changeLayout(withCard(layout.value, card));
}
