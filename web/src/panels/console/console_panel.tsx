// The log of nodes and boards: /rosout with level, node and search.
import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useLayoutEffect, useMemo, useRef } from "preact/hooks";
import { EmptyState, IconButton, SearchField } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { useSubscription, useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { LEVELS, type Level, type LogLine, LogLines } from "./log_lines.ts";

interface ConsoleSettings {
  level?: Level;
  node?: string;
  search?: string;
}

// Made once: one for each line would use most of the time in a flood. "h23": midnight is 00, not 24.
const CLOCK = new Intl.DateTimeFormat([], { timeStyle: "medium", hourCycle: "h23" });

// Enough to scroll through; more lines would make the page slow.
const MAX_SHOWN = 500;

function ConsolePanel({ context }: { context: PanelContext }) {
  const settings = context.settings as Signal<ConsoleSettings>;
  const log = useMemo(() => new LogLines(), []);
  const paused = useSignal<LogLine[] | undefined>(undefined);
  const { level = "info", node = "", search = "" } = settings.value;
  const feed = context.robot.feed("/rosout");
  const add = () => {
    const message = feed.lastValid();
    const type = feed.topic.peek()?.typeName ?? "";
    if (message) log.add(message, type);
  };
  useSubscription(context, "/rosout", add, true);
  useTick(context, 250);
  const change = (to: ConsoleSettings) => {
    settings.value = { ...settings.value, ...to };
  };
  const lines = paused.value ?? log.filtered(level, node, search);
  return (
    <div class="console">
      <div class="toolbar">
        <select
          aria-label={texts.console.level}
          value={level}
          onChange={(event) => change({ level: event.currentTarget.value as Level })}
        >
          {LEVELS.map((each) => (
            <option key={each} value={each}>
              {texts.console.atLeast(texts.console.levels[each])}
            </option>
          ))}
        </select>
        <select
          aria-label={texts.console.node}
          value={node}
          onChange={(event) => change({ node: event.currentTarget.value })}
        >
          <option value="">{texts.console.allNodes}</option>
          {log.nodes().map((each) => (
            <option key={each} value={each}>
              {each}
            </option>
          ))}
        </select>
        <SearchField
          value={search}
          label={texts.console.search}
          onInput={(text) => change({ search: text })}
        />
        <IconButton
          icon={paused.value ? "play" : "pause"}
          label={paused.value ? texts.console.resume : texts.console.pause}
          onClick={() => {
            paused.value = paused.value ? undefined : log.filtered(level, node, search);
          }}
        />
        <IconButton icon="trash" label={texts.console.clear} onClick={() => log.clear()} />
      </div>
      {lines.length === 0 ? (
        <EmptyState icon="console" title={texts.console.none} text={texts.console.noneText} />
      ) : (
        <Lines lines={lines.slice(-MAX_SHOWN)} />
      )}
    </div>
  );
}

function clockTime(timeS: number): string {
  return Number.isFinite(timeS) ? CLOCK.format(timeS * 1000) : "";
}

function Lines({ lines }: { lines: LogLine[] }) {
  const list = useRef<HTMLOListElement>(null);
  const isAtEnd = useRef(true);
  // New lines stay in view, unless the reader has scrolled back.
  useLayoutEffect(() => {
    if (list.current && isAtEnd.current) list.current.scrollTop = list.current.scrollHeight;
  });
  useEffect(() => {
    const element = list.current;
    if (element === null) return undefined;
    const onScroll = () => {
      isAtEnd.current = element.scrollHeight - element.scrollTop - element.clientHeight < 30;
    };
    element.addEventListener("scroll", onScroll, { passive: true });
    return () => element.removeEventListener("scroll", onScroll);
  }, []);
  return (
    <ol class="log" ref={list}>
      {lines.map((line) => (
        <li key={line.id} class={`log-line ${line.level}`} title={line.source || undefined}>
          <time>{clockTime(line.timeS)}</time>
          <span class="log-level">{texts.console.levels[line.level]}</span>
          <span class="log-node">{line.node}</span>
          <span class="log-text">{line.text}</span>
        </li>
      ))}
    </ol>
  );
}

export default preactPanel(ConsolePanel);
