// The first screen: a card for each thing that the graph has, with no configuration.
import { computed, signal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { graphOf } from "../panels/graph_of.ts";
import { mountPanel } from "../panels/host.ts";
import type { Panel, Suggestion } from "../panels/panel.ts";
import { panels } from "../panels/registry.ts";
import type { Robot } from "../store/robot.ts";
import { texts } from "../texts.ts";
import { Icon } from "./icons.tsx";
import { EmptyState } from "./parts.tsx";
import { linkTo } from "./route.ts";

interface Card extends Suggestion {
  panel: Panel;
}

// More than fits anybody's attention; each card costs a subscription.
const MAX_CARDS = 40;

export function Overview({ robot }: { robot: Robot }) {
  const cards = useMemo(() => computed(() => suggestedCards(robot)), [robot]);
  if (cards.value.length === 0) {
    const isOpen = robot.connection.value === "open";
    return isOpen ? (
      <EmptyState
        icon="boards"
        title={texts.overview.emptyTitle}
        text={texts.overview.emptyText}
        command={texts.overview.emptyCommand}
      />
    ) : (
      <EmptyState icon="boards" title={texts.overview.waiting} text={texts.overview.waitingText} />
    );
  }
  return (
    <div class="cards">
      {cards.value.map((each) => (
        <CardView key={`${each.panel.id} ${each.key}`} card={each} robot={robot} />
      ))}
    </div>
  );
}

function suggestedCards(robot: Robot): Card[] {
  const graph = graphOf(robot);
  const cards = panels.flatMap((panel) => (panel.matches?.(graph) ?? []).map((each) => ({ ...each, panel })));
  cards.sort((a, b) => a.order - b.order || (a.key < b.key ? -1 : 1));
  return cards.slice(0, MAX_CARDS);
}

function CardView({ card, robot }: { card: Card; robot: Robot }) {
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => mountPanel(card.panel, host.current!, robot, signal(card.settings), true), [robot]);
  return (
    <section class={`card width-${card.width ?? 1} card-${card.panel.id}`} aria-label={card.title}>
      <a class="card-head" href={linkTo(card.panel.id, card.settings)}>
        <Icon name={card.panel.icon} size={18} />
        <h2>{card.title}</h2>
        <Icon name="chevron" size={16} />
      </a>
      <div class="card-body" ref={host} />
    </section>
  );
}
