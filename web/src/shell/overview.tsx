// The first screen: cards for what the graph contains, without configuration, and the user's changes.
import { computed, signal, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useMemo, useRef } from "preact/hooks";
import { graphOf } from "../panels/graph_of.ts";
import { mountPanel } from "../panels/host.ts";
import type { Panel, Suggestion } from "../panels/panel.ts";
import { panels } from "../panels/registry.ts";
import { validSettings } from "../panels/setting_checks.ts";
import type { Robot } from "../store/robot.ts";
import { texts } from "../texts.ts";
import { compareNames } from "./format.ts";
import { Icon } from "./icons.tsx";
import { arranged, type Layout, moved, type Width, withoutCard } from "./layout.ts";
import { changeLayout, layout, resetLayout } from "./layout_state.ts";
import { CopyButton, EmptyState, IconButton } from "./parts.tsx";
import { linkTo } from "./route.ts";
import { saveChanges, sharedSettings } from "./saved_settings.ts";

interface Card extends Suggestion {
  id: string;
  panel: Panel;
}

// More cards are not readable, and each card needs a subscription.
const MAX_CARDS = 40;

// On a wide screen, wide cards follow the boards, so that narrow ones fill the columns beside them.
const WIDE_CARD_ORDER = 1;
const wideScreen = matchMedia("(min-width: 1000px)");
const isWide = signal(wideScreen.matches);
wideScreen.addEventListener("change", () => {
  isWide.value = wideScreen.matches;
});

export function Overview({ robot }: { robot: Robot }) {
  const cards = useMemo(() => computed(() => arranged(allCards(robot, layout.value), layout.value)), [robot]);
  const isArranging = useSignal(false);
  if (cards.value.length === 0 && !isArranging.value) {
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
    <>
      <h1 class="for-readers">{texts.panels.overview}</h1>
      <div class="cards">
        {cards.value.map((each) => (
          <CardView
            key={each.id}
            card={each}
            robot={robot}
            arrange={isArranging.value ? <ArrangeButtons card={each} shown={cards.value} /> : undefined}
          />
        ))}
      </div>
      <div class="arrange">
        <button
          type="button"
          class="button"
          aria-pressed={isArranging.value}
          onClick={() => {
            isArranging.value = !isArranging.value;
          }}
        >
          {isArranging.value ? texts.overview.done : texts.overview.arrange}
        </button>
        {isArranging.value && (
          <>
            <button type="button" class="button" onClick={resetLayout}>
              {texts.overview.reset}
            </button>
            <CopyButton
              text={`${location.origin}${location.pathname}${linkTo("", { ...layout.value })}`}
              label={texts.shell.copyLink}
            />
          </>
        )}
      </div>
    </>
  );
}

function allCards(robot: Robot, { added }: Layout): Card[] {
  const graph = graphOf(robot);
  const cards: Card[] = panels.flatMap((panel) =>
    (panel.matches?.(graph) ?? []).map((each) => ({ ...each, id: `${panel.id} ${each.key}`, panel })),
  );
  const orderOf = (card: Card) => (isWide.value && (card.width ?? 1) > 1 ? WIDE_CARD_ORDER : card.order);
  cards.sort((a, b) => orderOf(a) - orderOf(b) || compareNames(a.key, b.key));
  const known = new Set(cards.map((each) => each.id));
  for (const { panelId, ...each } of added) {
    const panel = panels.find((one) => one.id === panelId);
    const id = `${panelId} ${each.key}`;
    if (panel && !known.has(id)) {
      const settings = validSettings(each.settings, panel.settings);
      cards.push({ ...each, settings, id, panel, order: 100 });
    }
  }
  return cards.slice(0, MAX_CARDS);
}

function ArrangeButtons({ card, shown }: { card: Card; shown: Card[] }) {
  const t = texts.overview;
  const width = card.width ?? 1;
  const resize = () => {
    const wider = ((width % 3) + 1) as Width;
    changeLayout({ ...layout.value, widths: { ...layout.value.widths, [card.id]: wider } });
  };
  return (
    <>
      <IconButton
        icon="back"
        label={t.before}
        onClick={() => changeLayout(moved(layout.value, shown, card.id, -1))}
      />
      <IconButton
        icon="chevron"
        label={t.after}
        onClick={() => changeLayout(moved(layout.value, shown, card.id, 1))}
      />
      <IconButton icon="fit" label={t.width} onClick={resize} />
      <IconButton
        icon="close"
        label={t.hide}
        onClick={() => changeLayout(withoutCard(layout.value, card.id))}
      />
    </>
  );
}

function CardView({ card, robot, arrange }: { card: Card; robot: Robot; arrange: ComponentChildren }) {
  const host = useRef<HTMLDivElement>(null);
  const frame = useRef<HTMLElement>(null);
  useLayoutEffect(() => {
    const settings = signal({ ...sharedSettings(card.panel), ...card.settings });
    const dispose = mountPanel(card.panel, host.current!, robot, settings, true);
    const stopSaving = saveChanges(card.panel, settings, () => card.settings);
    return () => {
      stopSaving();
      dispose();
    };
  }, [robot]);
  useEffect(() => followHeight(frame.current!), []);
  return (
    <section
      class={`card width-${card.width ?? 1} card-${card.panel.id}`}
      aria-label={card.title}
      ref={frame}
    >
      <div class="card-head">
        <a href={linkTo(card.panel.id, card.settings)}>
          <Icon name={card.panel.icon} size={18} />
          <h2 title={card.title}>{card.title}</h2>
          {!arrange && <Icon name="chevron" size={16} />}
        </a>
        {arrange}
      </div>
      <div class="card-body" ref={host} />
    </section>
  );
}

/** The height of the grid's rows: `grid-auto-rows` in shell.css. */
const ROW_PX = 4;

/** Lets a card span the rows that it needs; returns a function that stops it. */
function followHeight(card: HTMLElement): () => void {
  const observer = new ResizeObserver(() => {
    const marginPx = Number.parseFloat(getComputedStyle(card).marginBottom);
    card.style.gridRowEnd = `span ${Math.ceil((card.offsetHeight + marginPx) / ROW_PX)}`;
  });
  observer.observe(card);
  return () => observer.disconnect();
}
