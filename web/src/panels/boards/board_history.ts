// The values of each board in the last minutes, for its sparklines; kept while the page is open.
import { compareNames } from "../../shell/format.ts";
import type { Robot } from "../../store/robot.ts";
import { type BoardStatus, numberOf } from "./board_status.ts";

/** At one status a second, two minutes. */
export const HISTORY_LENGTH = 120;
// A status is due each second.
const STALE_MS = 3000;
// The oldest absent boards are removed, so that many boards cannot fill the memory.
const MAX_BOARDS = 200;

const HISTORY_KEYS = [
  "received [bytes/s]",
  "sent [bytes/s]",
  "round trip [ms]",
  "clock offset [ms]",
  "clock drift [ppm]",
] as const;
export type HistoryKey = (typeof HISTORY_KEYS)[number];

export interface Board {
  status: BoardStatus;
  receivedMs: number;
  history: Record<HistoryKey, number[]>;
}

export class Boards {
  readonly byName = new Map<string, Board>();

  add(status: BoardStatus, nowMs: number): void {
    let board = this.byName.get(status.name);
    if (!board) {
      if (this.byName.size >= MAX_BOARDS) this.byName.delete(this.byName.keys().next().value!);
      const history = Object.fromEntries(HISTORY_KEYS.map((key) => [key, [] as number[]]));
      board = { status, receivedMs: nowMs, history: history as Board["history"] };
      this.byName.set(status.name, board);
    }
    board.status = status;
    board.receivedMs = nowMs;
    for (const key of HISTORY_KEYS) {
      const values = board.history[key];
      values.push(numberOf(status.values, key) ?? Number.NaN);
      if (values.length > HISTORY_LENGTH) values.shift();
    }
  }

  sorted(): Board[] {
    return [...this.byName.values()].sort((a, b) => compareNames(a.status.name, b.status.name));
  }
}

export function isStale(board: Board, nowMs: number): boolean {
  return nowMs - board.receivedMs > STALE_MS;
}

const known = new WeakMap<Robot, Boards>();

export function boardsOf(robot: Robot): Boards {
  let boards = known.get(robot);
  if (!boards) {
    boards = new Boards();
    known.set(robot, boards);
  }
  return boards;
}
