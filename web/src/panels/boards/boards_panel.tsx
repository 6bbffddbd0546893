// All boards that report on /diagnostics.
import { formatBandwidth, formatDuration } from "../../shell/format.ts";
import { Badge, EmptyState } from "../../shell/parts.tsx";
import { Sparkline } from "../../shell/sparkline.tsx";
import { texts } from "../../texts.ts";
import { useFeed, useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { BoardCard, boardLevel, Findings, LineLoad, stateText } from "./board_card.tsx";
import { type Board, boardsOf, HISTORY_LENGTH } from "./board_history.ts";
import { boardStatuses, numberOf } from "./board_status.ts";

const TOPIC = "/diagnostics";
const TICK_MS = 1000;

function BoardsPanel({ context }: { context: PanelContext }) {
  const boards = boardsOf(context.robot);
  const feed = useFeed(context, TOPIC, (arrival) => {
    const array = feed.decode(arrival.payload);
    if (!array || array instanceof Error) return;
    for (const each of boardStatuses(array)) boards.add(each, arrival.receivedMs);
  });
  useTick(context, TICK_MS);
  const nowMs = performance.now();
  const shown = boards.sorted();
  if (shown.length === 0) {
    if (context.isCard) return <p class="muted">{feed.last ? texts.boards.none : texts.boards.waiting}</p>;
    return (
      <EmptyState
        icon="boards"
        title={texts.boards.none}
        text={texts.boards.noneText}
        command={texts.overview.emptyCommand}
      />
    );
  }
  if (context.isCard) {
    return (
      <div class="boards-rows">
        {shown.map((each) => (
          <BoardRow key={each.status.name} board={each} nowMs={nowMs} />
        ))}
      </div>
    );
  }
  return (
    <div class="boards">
      {shown.map((each) => (
        <BoardCard key={each.status.name} board={each} nowMs={nowMs} robot={context.robot} />
      ))}
    </div>
  );
}

/** A board on the overview: its most important values. */
function BoardRow({ board, nowMs }: { board: Board; nowMs: number }) {
  const { values, findings, level, name } = board.status;
  const roundTrip = numberOf(values, "round trip [ms]");
  const shownLevel = boardLevel(board, nowMs);
  return (
    <div class={shownLevel === "stale" ? "boards-row is-stale" : "boards-row"}>
      <div class="board-head">
        <h3>{name}</h3>
        <Badge level={shownLevel}>{stateText(board, nowMs)}</Badge>
      </div>
      <div class="boards-row-figures">
        <div class="figure">
          <span class="board-label">{texts.boards.received}</span>
          <span class="figure-value">{formatBandwidth(numberOf(values, "received [bytes/s]") ?? 0)}</span>
        </div>
        <div class="figure">
          <span class="board-label">{texts.boards.roundTrip}</span>
          <span class="figure-value">{roundTrip === undefined ? "–" : `${roundTrip.toFixed(1)} ms`}</span>
        </div>
        <Sparkline values={board.history["received [bytes/s]"]} length={HISTORY_LENGTH} />
      </div>
      <LineLoad board={board} />
      <p class="muted boards-row-summary">{summary(board)}</p>
      <Findings findings={findings} level={level} />
    </div>
  );
}

/** The number of the board's topics, its losses, and the time since it connected. */
function summary({ status }: Board): string {
  const connected = numberOf(status.values, "connected [s]");
  const dropped = status.endpoints.reduce((sum, each) => sum + each.dropped, 0);
  const parts = [
    texts.boards.topics(status.endpoints.length),
    texts.boards.lost(dropped, numberOf(status.values, "checksum errors") ?? 0),
  ];
  if (connected !== undefined) parts.push(texts.boards.connectedFor(formatDuration(connected)));
  return parts.join(" · ");
}

export default preactPanel(BoardsPanel);
