// The health of every component that publishes on /diagnostics.
import { useMemo } from "preact/hooks";
import { Icon } from "../../shell/icons.tsx";
import { Badge, EmptyState } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { useSubscription, useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { StatusTable } from "./status_table.ts";

function DiagnosticsPanel({ context }: { context: PanelContext }) {
  const table = useMemo(() => new StatusTable(), []);
  const feed = context.robot.feed("/diagnostics");
  useSubscription(context, "/diagnostics", (arrival) => {
    const message = feed.lastValid();
    if (message) table.add(message, arrival.receivedMs);
  });
  const now = useTick(context, 500);
  const entries = table.sorted(now);
  if (entries.length === 0)
    return <EmptyState icon="diagnostics" title={texts.diagnostics.none} text={texts.diagnostics.noneText} />;
  return (
    <div class="diagnostics">
      {entries.map(({ status, level }) => (
        <details
          key={status.name}
          class={`diagnostic ${level}`}
          open={level === "error" || level === "warning"}
        >
          <summary>
            <Icon name="chevron" size={16} />
            <Badge level={level}>{texts.diagnostics.levels[level]}</Badge>
            <span class="diagnostic-name">{status.name}</span>
            <span class="diagnostic-message">{status.message}</span>
          </summary>
          <table class="values">
            <tbody>
              {status.values.map(({ key, value }, index) => (
                <tr key={index}>
                  <th scope="row">{key}</th>
                  <td>{value}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </details>
      ))}
    </div>
  );
}

export default preactPanel(DiagnosticsPanel);
