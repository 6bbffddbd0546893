// One board: its state, findings with the next step, line, clock and topics.
import type { ComponentChildren } from "preact";
import { formatBandwidth, formatBytes, formatDuration, formatRate } from "../../shell/format.ts";
import { Icon } from "../../shell/icons.tsx";
import { Badge, type Level } from "../../shell/parts.tsx";
import { linkTo } from "../../shell/route.ts";
import { Sparkline } from "../../shell/sparkline.tsx";
import type { Robot } from "../../store/robot.ts";
import { texts } from "../../texts.ts";
import { type Board, HISTORY_LENGTH, type HistoryKey, isStale } from "./board_history.ts";
import { type Endpoint, type Finding, numberOf } from "./board_status.ts";

// With start and stop bits, a byte is ten bits on the line.
const BITS_PER_BYTE = 10;
// Above this, bursts of messages begin to wait.
const HIGH_LOAD = 0.8;

const t = texts.boards;

export function boardLevel(board: Board, nowMs: number): Level {
  if (isStale(board, nowMs)) return "stale";
  return board.status.level >= 2 ? "error" : board.status.level === 1 ? "warning" : "ok";
}

export function stateText(board: Board, nowMs: number): string {
  if (isStale(board, nowMs)) return t.noReport(formatDuration((nowMs - board.receivedMs) / 1000));
  const state = board.status.values.get("state") ?? "";
  return t.states[state as keyof typeof t.states] ?? state;
}

/** The share of the line that is used in its busier direction, undefined without a baud rate. */
export function lineLoad(board: Board): { share: number; baud: number } | undefined {
  const { values } = board.status;
  const baud = numberOf(values, "baud rate");
  if (!baud) return undefined;
  const busier = Math.max(
    numberOf(values, "received [bytes/s]") ?? 0,
    numberOf(values, "sent [bytes/s]") ?? 0,
  );
  return { share: Math.min(1, (busier * BITS_PER_BYTE) / baud), baud };
}

export function BoardCard({ board, nowMs, robot }: { board: Board; nowMs: number; robot: Robot }) {
  const { status } = board;
  const { values } = status;
  const level = boardLevel(board, nowMs);
  const connected = numberOf(values, "connected [s]");
  // Without a connection there is no line to measure.
  const isConnected = values.get("state") !== "disconnected";
  return (
    <section class={level === "stale" ? "board is-stale" : "board"} aria-label={status.name}>
      <header class="board-head">
        <h2>{status.name}</h2>
        <Badge level={level}>{stateText(board, nowMs)}</Badge>
      </header>
      <p class="board-peer">
        {[values.get("peer"), connected !== undefined && t.connectedFor(formatDuration(connected))]
          .filter(Boolean)
          .join(" · ")}
      </p>
      <ProgramSize board={board} />
      <Findings findings={status.findings} level={status.level} />
      {isConnected && <LineFigures board={board} />}
      {status.endpoints.length > 0 && <Endpoints board={board} robot={robot} />}
    </section>
  );
}

/** The memory use of the board's sketch, if the robot knows the sketch. */
function ProgramSize({ board }: { board: Board }) {
  const bytes = (key: string) => numberOf(board.status.values, key);
  const [flash, ram] = [bytes("flash [bytes]"), bytes("RAM [bytes]")];
  if (flash === undefined || ram === undefined) return null;
  return (
    <p class="board-peer">
      {t.program(ofLimit(flash, bytes("flash limit [bytes]")), ofLimit(ram, bytes("RAM limit [bytes]")))}
    </p>
  );
}

function ofLimit(used: number, limit: number | undefined): string {
  return limit === undefined ? formatBytes(used) : t.ofLimit(formatBytes(used), formatBytes(limit));
}

function LineFigures({ board }: { board: Board }) {
  const { values, endpoints } = board.status;
  const dropped = endpoints.reduce((sum, each) => sum + each.dropped, 0);
  return (
    <>
      <LineLoad board={board} />
      <div class="board-figures">
        <Figure board={board} name={t.received} of="received [bytes/s]" text={formatBandwidth} />
        <Figure board={board} name={t.sent} of="sent [bytes/s]" text={formatBandwidth} />
        <Figure board={board} name={t.roundTrip} of="round trip [ms]" text={(ms) => `${ms.toFixed(1)} ms`} />
        <Figure
          board={board}
          name={t.clockOffset}
          of="clock offset [ms]"
          text={(ms) => `${signed(ms, 1)} ms`}
        />
        <Figure
          board={board}
          name={t.clockDrift}
          of="clock drift [ppm]"
          text={(ppm) => `${signed(ppm, 0)} ppm`}
        />
        <Count name={t.loopLate} value={numberOf(values, "loop late [ms]")} unit=" ms" />
      </div>
      <div class="board-counts">
        <Count name={t.frames} value={numberOf(values, "frames")} />
        <Count name={t.damaged} value={numberOf(values, "checksum errors")} isBad />
        <Count name={t.dropped} value={dropped} isBad />
        <Count name={t.reconnects} value={numberOf(values, "reconnects")} isBad />
        <Count name={t.resets} value={numberOf(values, "resets")} isBad />
        <Count name={t.queued} value={numberOf(values, "queued [bytes]")} unit=" B" />
      </div>
    </>
  );
}

export function Findings({ findings, level }: { findings: readonly Finding[]; level: number }) {
  return (
    <>
      {findings.map(({ code, seen, action }) => (
        <div key={code} class={level >= 2 ? "finding error" : "finding"}>
          <Icon name="warning" size={18} />
          <div>
            <p class="finding-seen">{withCode(sentence(seen))}</p>
            {action && <p>{withCode(sentence(action))}</p>}
          </div>
        </div>
      ))}
    </>
  );
}

export function LineLoad({ board }: { board: Board }) {
  const load = lineLoad(board);
  if (!load) return null;
  const percent = Math.round(load.share * 100);
  const setWidth = (element: HTMLElement | null) => {
    if (element) element.style.width = `${percent}%`;
  };
  return (
    <div class="board-load">
      <span class="board-label">{t.lineLoad}</span>
      <span class="board-load-bar">
        <span class={load.share > HIGH_LOAD ? "high" : undefined} ref={setWidth} />
      </span>
      <span>{t.loadOf(percent, load.baud)}</span>
    </div>
  );
}

function Figure(props: { board: Board; name: string; of: HistoryKey; text: (value: number) => string }) {
  const value = numberOf(props.board.status.values, props.of);
  return (
    <div class="figure">
      <span class="board-label">{props.name}</span>
      <span class="figure-value">{value === undefined ? "–" : props.text(value)}</span>
      <Sparkline values={props.board.history[props.of]} length={HISTORY_LENGTH} />
    </div>
  );
}

function Count(props: { name: string; value: number | undefined; unit?: string; isBad?: boolean }) {
  const isBad = props.isBad && props.value !== undefined && props.value > 0;
  return (
    <div class="figure">
      <span class="board-label">{props.name}</span>
      <span class={isBad ? "figure-value bad" : "figure-value"}>
        {props.value === undefined ? "–" : `${props.value.toLocaleString("en-US")}${props.unit ?? ""}`}
      </span>
    </div>
  );
}

function Endpoints({ board, robot }: { board: Board; robot: Robot }) {
  const namespace = board.status.name.includes("/") ? board.status.name.replace(/[^/]*$/, "") : "";
  const hasBuffers = board.status.endpoints.some((each) => each.bufferBytes !== undefined);
  return (
    <table class="board-topics">
      <thead>
        <tr>
          <th>{t.topic}</th>
          <th class="wide">{texts.topics.type}</th>
          <th class="number">{texts.topics.rate}</th>
          {hasBuffers && <th class="number">{t.buffer}</th>}
          <th class="number">{t.dropped}</th>
        </tr>
      </thead>
      <tbody>
        {board.status.endpoints.map((each) => (
          <tr key={`${each.role} ${each.topic}`}>
            <td>
              <span class="board-role" title={t.roles[each.role as keyof typeof t.roles]}>
                {each.role === "publisher" ? "→" : each.role === "subscriber" ? "←" : "⇄"}
              </span>
              <EndpointName endpoint={each} namespace={namespace} />
            </td>
            <td class="muted wide">{each.type}</td>
            <td class="number">{formatRate(each.hertz)}</td>
            {hasBuffers && (
              <td class="number">
                {bufferUse(each, robot.feed(topicOf(each, namespace)).last?.payload.length)}
              </td>
            )}
            <td class={each.dropped > 0 ? "number bad" : "number"}>{each.dropped.toLocaleString("en-US")}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function EndpointName({ endpoint, namespace }: { endpoint: Endpoint; namespace: string }) {
  if (endpoint.role.startsWith("service")) return <span>{endpoint.topic}</span>;
  const topic = topicOf(endpoint, namespace);
  return <a href={linkTo("topics", { topic })}>{endpoint.topic}</a>;
}

/** The topic's name on the graph: boards announce it relative to their namespace. */
function topicOf({ topic }: Endpoint, namespace: string): string {
  return topic.startsWith("/") ? topic : `/${namespace}${topic}`;
}

/** The size of the buffer that the board announced; if the page receives the topic, also the size of the last message. */
function bufferUse({ bufferBytes }: Endpoint, lastBytes: number | undefined): string {
  if (bufferBytes === undefined) return "–";
  return lastBytes === undefined ? formatBytes(bufferBytes) : t.sizeOf(lastBytes, formatBytes(bufferBytes));
}

/** Shows text between backticks as code. */
function withCode(text: string): ComponentChildren {
  // The order of the parts never changes, so the index can be the key.
  return text.split("`").map((part, index) => (index % 2 ? <code key={`${index}`}>{part}</code> : part));
}

function signed(value: number, digits: number): string {
  return `${value > 0 ? "+" : ""}${value.toFixed(digits)}`;
}

/** A part of a finding as a sentence: the parts have no capital and no full stop. Code such as `loop()` keeps its case. */
function sentence(text: string): string {
  const begun = /^\w+\(/.test(text) ? text : `${text.charAt(0).toUpperCase()}${text.slice(1)}`;
  return `${begun}${/[.!?]$/.test(text) ? "" : "."}`;
}
