// Visibility: a panel is visible while a part of it is on the screen and the page is not hidden.
import { computed, type ReadonlySignal, signal } from "@preact/signals";

export const pageHidden = signal(document.hidden);
document.addEventListener("visibilitychange", () => {
  pageHidden.value = document.hidden;
});

const onScreen = new WeakMap<Element, (isOnScreen: boolean) => void>();
const observer = new IntersectionObserver(
  (entries) => {
    for (const each of entries) onScreen.get(each.target)?.(each.isIntersecting);
  },
  // Panels just outside the screen start before they are visible.
  { rootMargin: "100px" },
);

/** Watches whether an element is visible, until `dispose`. */
export function watchVisible(element: Element): { visible: ReadonlySignal<boolean>; dispose(): void } {
  const isOnScreen = signal(true);
  onScreen.set(element, (now) => {
    isOnScreen.value = now;
  });
  observer.observe(element);
  return {
    visible: computed(() => isOnScreen.value && !pageHidden.value),
    dispose() {
      observer.unobserve(element);
      onScreen.delete(element);
    },
  };
}
