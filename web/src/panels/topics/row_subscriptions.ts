// Subscribes to the topics whose rows are visible, so that a long list costs only the rows on the screen.
import { useEffect, useRef } from "preact/hooks";
import type { PanelContext } from "../panel.ts";

/** Returns the reference for the table's body, whose rows name their topics as `data-topic`. */
export function useRowSubscriptions(
  context: PanelContext,
  scroll: { current: HTMLElement | null },
  rows: readonly { name: string }[],
) {
  const body = useRef<HTMLTableSectionElement>(null);
  const open = useRef(new Map<string, { close(): void }>());
  const names = rows.map((each) => each.name).join("\n");
  useEffect(() => {
    const observer = new IntersectionObserver(
      (entries) => {
        for (const { target, isIntersecting } of entries) {
          const topic = (target as HTMLElement).dataset.topic!;
          if (isIntersecting) {
            if (!open.current.has(topic)) open.current.set(topic, context.subscribe(topic));
          } else {
            open.current.get(topic)?.close();
            open.current.delete(topic);
          }
        }
      },
      { root: scroll.current },
    );
    for (const row of body.current!.querySelectorAll("tr[data-topic]")) observer.observe(row);
    return () => {
      observer.disconnect();
      for (const each of open.current.values()) each.close();
      open.current.clear();
    };
  }, [names]);
  return body;
}
