// The user's changes to the automatic overview: order, widths, hidden and added cards.
import type { Settings } from "../panels/setting_checks.ts";

export type Width = 1 | 2 | 3;

export interface AddedCard {
  panelId: string;
  key: string;
  title: string;
  settings: Settings;
}

export interface Layout {
  /** Ids of cards in the user's order; empty until a card is moved. Other cards follow. */
  order: string[];
  hidden: string[];
  widths: Record<string, Width>;
  added: AddedCard[];
}

export const NO_LAYOUT: Layout = { order: [], hidden: [], widths: {}, added: [] };
// Links and storage may contain anything.
const MAX_ITEMS = 200;

/** Reads a layout from a link or from storage; invalid parts are omitted. */
export function readLayout(value: Settings | undefined): Layout {
  if (!value) return NO_LAYOUT;
  const widths: Record<string, Width> = {};
  for (const [id, width] of Object.entries(asObject(value.widths)).slice(0, MAX_ITEMS)) {
    if (width === 1 || width === 2 || width === 3) widths[id] = width;
  }
  const added = Array.isArray(value.added) ? value.added.slice(0, MAX_ITEMS).filter(isAddedCard) : [];
  return { order: strings(value.order), hidden: strings(value.hidden), widths, added };
}

/** Arranges the cards as in the layout. */
export function arranged<Card extends { id: string; width?: Width }>(
  cards: readonly Card[],
  layout: Layout,
): Card[] {
  const hidden = new Set(layout.hidden);
  const indexes = new Map(layout.order.map((id, index) => [id, index]));
  return cards
    .filter((each) => !hidden.has(each.id))
    .map((card, index) => ({ card, at: indexes.get(card.id) ?? layout.order.length + index }))
    .sort((a, b) => a.at - b.at)
    .map(({ card }) => {
      const width = layout.widths[card.id];
      return width ? { ...card, width } : card;
    });
}

/** Moves a card by one position among those that are shown. */
export function moved(layout: Layout, shown: readonly { id: string }[], id: string, by: -1 | 1): Layout {
  const order = shown.map((each) => each.id);
  const from = order.indexOf(id);
  const to = from + by;
  if (from < 0 || to < 0 || to >= order.length) return layout;
  [order[from], order[to]] = [order[to]!, order[from]!];
  return { ...layout, order };
}

/** Adds a card; if it was already added, it moves to the end. */
export function withCard(layout: Layout, card: AddedCard): Layout {
  const id = `${card.panelId} ${card.key}`;
  return {
    ...layout,
    hidden: layout.hidden.filter((each) => each !== id),
    added: [...layout.added.filter((each) => `${each.panelId} ${each.key}` !== id), card].slice(-MAX_ITEMS),
  };
}

/** Removes an added card; hides an automatic one until the layout is reset. */
export function withoutCard(layout: Layout, id: string): Layout {
  const added = layout.added.filter((each) => `${each.panelId} ${each.key}` !== id);
  if (added.length < layout.added.length) return { ...layout, added };
  return { ...layout, hidden: [...layout.hidden, id].slice(-MAX_ITEMS) };
}

function asObject(value: unknown): object {
  return typeof value === "object" && value !== null ? value : {};
}

function strings(value: unknown): string[] {
  return Array.isArray(value) ? value.slice(0, MAX_ITEMS).filter((each) => typeof each === "string") : [];
}

function isAddedCard(value: unknown): value is AddedCard {
  const { panelId, key, title, settings } = asObject(value) as Record<string, unknown>;
  return (
    typeof panelId === "string" &&
    typeof key === "string" &&
    typeof title === "string" &&
    typeof settings === "object" &&
    settings !== null
  );
}
