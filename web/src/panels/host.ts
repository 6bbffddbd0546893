// Mounts a panel into an element: loads its code, watches whether it is visible, and ends its subscriptions.
import { effect, type Signal } from "@preact/signals";
import { navigate } from "../shell/route.ts";
import type { Listener } from "../store/feed.ts";
import type { Robot, Subscription } from "../store/robot.ts";
import { watchVisible } from "../store/visibility.ts";
import { texts } from "../texts.ts";
import type { Panel, PanelContext } from "./panel.ts";
import type { Settings } from "./setting_checks.ts";

// A robot that restarts is back within seconds.
const RETRY_MS = 1000;
// A card that is loaded late waits no longer than this for the others.
const MAX_WAIT_MS = 1500;

/** Mounts `panel` in `host`; returns a function that removes it. */
export function mountPanel(
  panel: Panel,
  host: HTMLElement,
  robot: Robot,
  settings: Signal<Settings>,
  isCard: boolean,
): () => void {
  const watched = watchVisible(host);
  const endings = new Set<() => void>();
  let isDisposed = false;

  const context: PanelContext = {
    robot,
    settings,
    visible: watched.visible,
    isCard,
    subscribe(topicName: string, listener?: Listener, withLatched?: boolean) {
      let subscription: Subscription | undefined;
      const end = effect(() => {
        if (watched.visible.value) subscription ??= robot.subscribe(topicName, listener, withLatched);
        else {
          subscription?.close();
          subscription = undefined;
        }
      });
      const close = () => {
        endings.delete(close);
        end();
        subscription?.close();
        subscription = undefined;
      };
      endings.add(close);
      return { feed: robot.feed(topicName), close };
    },
    open: navigate,
  };

  let retry: ReturnType<typeof setTimeout> | undefined;
  const load = () => {
    if (isDisposed) return;
    panel.load().then(
      ({ default: module }) => {
        if (isDisposed) return;
        host.replaceChildren();
        endings.add(module.mount(host, context));
      },
      (error: unknown) => {
        if (isDisposed) return;
        console.warn(error);
        host.textContent = texts.shell.loadFailed;
        // The robot may be disconnected now.
        retry = setTimeout(load, RETRY_MS);
      },
    );
  };
  if (isCard && panel.loadsLate) {
    // By the first pause, the other cards have subscribed.
    void pause()
      .then(() => robot.firstValues(MAX_WAIT_MS))
      .then(pause)
      .then(load);
  } else load();

  return () => {
    isDisposed = true;
    clearTimeout(retry);
    watched.dispose();
    for (const each of [...endings]) each();
    endings.clear();
    host.replaceChildren();
  };
}

/** Resolves when the browser is idle. */
function pause(): Promise<void> {
  return new Promise((resolve) => {
    // Safari has no idle callbacks.
    if ("requestIdleCallback" in globalThis) requestIdleCallback(() => resolve(), { timeout: MAX_WAIT_MS });
    else setTimeout(resolve, MAX_WAIT_MS / 2);
  });
}
