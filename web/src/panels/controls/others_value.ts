// The value that other publishers of a topic sent last: other pages, scripts, a joystick.
import { useEffect, useRef } from "preact/hooks";
import type { Message } from "../../wire/decode.ts";
import { useSubscription } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";

// While it is used, a control must not jump back to its own earlier values, which return from the robot.
const OWN_MS = 500;

/**
 * Calls `show` with the messages of a topic while the control is visible; returns a function that the
 * control must call when it sends a message.
 */
export function useOthersValue(
  context: PanelContext,
  topicName: string,
  show: (message: Message) => void,
): () => void {
  const timer = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  const isWaiting = useRef(false);
  useEffect(() => () => clearTimeout(timer.current), []);
  const showLast = () => {
    const message = context.robot.feed(topicName).lastValid();
    if (message) show(message);
  };
  useSubscription(context, topicName, () => {
    isWaiting.current = timer.current !== undefined;
    if (!isWaiting.current) showLast();
  });
  return () => {
    clearTimeout(timer.current);
    timer.current = setTimeout(() => {
      timer.current = undefined;
      if (isWaiting.current) showLast();
    }, OWN_MS);
  };
}
