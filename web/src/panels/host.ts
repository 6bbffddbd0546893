// Mounts a panel into an element: loads its code, watches whether it is seen, and ends its subscriptions.
import { effect, type Signal } from "@preact/signals";
import { navigate } from "../shell/route.ts";
import type { Listener } from "../store/feed.ts";
import type { Robot, Subscription } from "../store/robot.ts";
import { watchVisible } from "../store/visibility.ts";
import { texts } from "../texts.ts";
import type { Panel, PanelContext, Settings } from "./panel.ts";

// A robot that restarts is back within seconds.
const RETRY_MS = 1000;

/** Mounts `panel` in `host`; returns what removes it. */
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
    subscribe(topicName: string, listener?: Listener) {
      let subscription: Subscription | undefined;
      const end = effect(() => {
        if (watched.visible.value) subscription ??= robot.subscribe(topicName, listener);
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
        // The robot may be away just now.
        retry = setTimeout(load, RETRY_MS);
      },
    );
  };
  load();

  return () => {
    isDisposed = true;
    clearTimeout(retry);
    watched.dispose();
    for (const each of [...endings]) each();
    endings.clear();
    host.replaceChildren();
  };
}
