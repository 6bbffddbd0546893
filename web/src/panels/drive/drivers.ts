// The drivers of the page, one per topic, and one stop for all of them.
import type { Robot } from "../../store/robot.ts";
import { graphOf } from "../graph_of.ts";
import { DEFAULT_LIMITS } from "./commands.ts";
import { drivableTopics } from "./drivable.ts";
import { Driver } from "./driver.ts";

const drivers = new Map<string, { driver: Driver; definition: string }>();

/** The driver of a topic, shared by all callers: undefined if the topic was never seen or its type is not readable. */
export function driverOf(robot: Robot, topicName: string): Driver | undefined {
  const topic = robot.topics.peek().get(topicName);
  const known = drivers.get(topicName);
  if (topic === undefined || known?.definition === topic.definition) return known?.driver;
  known?.driver.dispose();
  drivers.delete(topicName);
  try {
    const driver = new Driver(robot, topic, known?.driver.limits ?? DEFAULT_LIMITS);
    drivers.set(topicName, { driver, definition: topic.definition });
    return driver;
  } catch {
    return undefined;
  }
}

/** Creates the drivers in advance, so that the first stop need not wait for the robot to accept their topics. */
export function prepareStop(robot: Robot): void {
  if (robot.mayAct.peek()) for (const topic of drivableTopics(graphOf(robot))) driverOf(robot, topic);
}

/** Stops everything that this page can drive. */
export function stopAll(robot: Robot): void {
  for (const topic of drivableTopics(graphOf(robot))) driverOf(robot, topic)?.stop();
}

/** A page that is hidden or left releases the stick. */
export function releaseWhenHidden(): void {
  const release = () => {
    for (const { driver } of drivers.values()) driver.release();
  };
  addEventListener("pagehide", release);
  addEventListener("blur", release);
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) release();
  });
}
