// Hooks for panels that are Preact components. They subscribe without waiting until the browser has painted.
import { useSignal } from "@preact/signals";
import { useEffect, useLayoutEffect, useMemo } from "preact/hooks";
import type { Feed, Listener } from "../store/feed.ts";
import type { PanelContext } from "./panel.ts";

/** Subscribes while the panel is visible; the component is drawn again for new messages, at most once a frame. */
export function useFeed(context: PanelContext, topicName: string, listener?: Listener): Feed {
  const feed = useMemo(() => context.robot.feed(topicName), [topicName]);
  useLayoutEffect(() => {
    const subscription = context.subscribe(topicName, listener);
    return () => subscription.close();
  }, [topicName]);
  void feed.version.value;
  return feed;
}

/** Subscribes without drawing again on messages: for panels that draw themselves, or once a second. */
export function useSubscription(
  context: PanelContext,
  topicName: string | undefined,
  listener?: Listener,
  withLatched?: boolean,
): void {
  useLayoutEffect(() => {
    if (topicName === undefined) return;
    const subscription = context.subscribe(topicName, listener, withLatched);
    return () => subscription.close();
  }, [topicName]);
}

/** Draws the component again every `periodMs` while the panel is visible; returns `performance.now()`. */
export function useTick(context: PanelContext, periodMs: number): number {
  const now = useSignal(performance.now());
  const isVisible = context.visible.value;
  useEffect(() => {
    if (!isVisible) return;
    const timer = setInterval(() => {
      now.value = performance.now();
    }, periodMs);
    return () => clearInterval(timer);
  }, [isVisible, periodMs]);
  return now.value;
}
