// The header: the robot's name, whether it is connected, the stop button, colors.
import type { Robot } from "../store/robot.ts";
import { texts } from "../texts.ts";
import { Badge, IconButton, type Level } from "./parts.tsx";
import { StopButton } from "./stop_button.tsx";
import { theme, toggleTheme } from "./theme.ts";

/** The id of the gateway's status while it cannot read the graph. */
const GRAPH_STATUS_ID = "graph";
// A reason may contain text that a page has sent.
const MAX_REASON = 500;

export function Header({ robot }: { robot: Robot }) {
  const state = robot.connection.value;
  const level: Level = state === "open" ? "ok" : state === "lost" ? "error" : "stale";
  const lost = robot.info.value ? texts.shell.lost : texts.shell.notConnected;
  const label = { open: texts.shell.connected, lost, connecting: texts.shell.connecting }[state];
  const isDark = theme.value === "dark";
  const problem = state === "open" && robot.statuses.value.find((each) => each.id === GRAPH_STATUS_ID);
  return (
    <>
      <header class="header">
        <a class="brand" href="#/">
          {robot.info.value?.name ?? "rostether"}
        </a>
        <span class="connection" role="status">
          <Badge level={level}>{label}</Badge>
          {robot.simulatedTimeNs.value !== undefined && (
            <Badge level="warning">{texts.shell.simulatedTime}</Badge>
          )}
        </span>
        {robot.info.value?.metadata?.rights === "view" && <Badge level="stale">{texts.shell.viewOnly}</Badge>}
        <span class="spring" />
        <StopButton robot={robot} />
        <IconButton
          icon={isDark ? "sun" : "moon"}
          label={isDark ? texts.shell.light : texts.shell.dark}
          onClick={toggleTheme}
        />
      </header>
      {problem && (
        <div class="banner warning" role="alert">
          {`${problem.message}. ${texts.shell.graphProblemDetail}`}
        </div>
      )}
      {state === "open" && !problem && robot.refusal.value && (
        <div class="banner warning" role="alert">
          {`${robot.refusal.value.slice(0, MAX_REASON)}.`}
        </div>
      )}
      {state === "lost" && (
        <div class="banner" role="alert">
          {robot.info.value
            ? `${robot.lostReason.value || texts.shell.lost}. ${texts.shell.lostDetail}`
            : robot.lostReason.value
              ? `${robot.lostReason.value}.`
              : texts.shell.neverConnected}
        </div>
      )}
    </>
  );
}
