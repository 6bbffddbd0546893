// The page's data of the robot, as signals, and the subscriptions that its panels share.
import { batch, computed, type ReadonlySignal, type Signal, signal } from "@preact/signals";
import { Gateway } from "../connection/gateway.ts";
import type { GraphUpdate, Recordings, ServerInfo, Service, Status } from "../connection/protocol.ts";
import { texts } from "../texts.ts";
import { Feed, type Listener } from "./feed.ts";
import { frameTask } from "./frames.ts";
import { Parameters } from "./parameters.ts";
import { Topic } from "./topics.ts";

export type ConnectionState = "connecting" | "open" | "lost";

// A quick change of pages must not end and begin subscriptions.
const UNSUBSCRIBE_DELAY_MS = 300;
// Users do not read a longer list.
const MAX_STATUSES = 50;
// Long enough to read a sentence twice.
const REFUSAL_MS = 10_000;
const NONE: ReadonlyMap<string, readonly string[]> = new Map();

interface Use {
  count: number;
  subscriptionId: number | undefined;
  endTimer: ReturnType<typeof setTimeout> | undefined;
}

export interface Subscription {
  readonly feed: Feed;
  close(): void;
}

export class Robot {
  readonly connection: Signal<ConnectionState> = signal("connecting");
  /** Why the connection was lost, the server's reason; may be empty. */
  readonly lostReason = signal("");
  readonly canCommand = signal(false);
  /** Whether this page may publish, call, set and record; also false without a connection. */
  readonly mayAct: ReadonlySignal<boolean> = computed(
    () => this.canCommand.value && this.info.value?.metadata?.rights !== "view",
  );
  readonly recordings: Signal<Recordings | undefined> = signal(undefined);
  readonly info: Signal<ServerInfo | undefined> = signal(undefined);
  /**
   * Topics by name, including those that only have subscribers (`isPublished` is false).
   * After a lost connection they stay until the new one has announced its own.
   */
  readonly topics: Signal<ReadonlyMap<string, Topic>> = signal(new Map());
  readonly services: Signal<ReadonlyMap<string, Service>> = signal(new Map());
  /** Nodes that publish each topic, and nodes that subscribe to it. */
  readonly publishers = signal(NONE);
  readonly subscribers = signal(NONE);
  readonly statuses: Signal<readonly Status[]> = signal([]);
  /** Why the robot refused the page's last request; empty after some time. */
  readonly refusal = signal("");
  /** The robot's simulated clock in nanoseconds, undefined while it runs in real time. */
  readonly simulatedTimeNs: Signal<bigint | undefined> = signal(undefined);
  readonly parameters: Parameters;
  readonly gateway: Gateway;

  /** Topics that a node publishes, by channel; and topics that only have subscribers, by name. */
  private readonly channels = new Map<number, Topic>();
  private readonly unpublished = new Map<string, Topic>();
  private readonly feeds = new Map<string, Feed>();
  private readonly uses = new Map<string, Use>();
  private readonly bySubscription = new Map<number, Feed>();
  private readonly changed = new Set<Feed>();
  /** Feeds that are subscribed and have had no message yet. */
  private readonly empty = new Set<Feed>();
  private readonly onNoneEmpty = new Set<() => void>();
  private refusalTimer: ReturnType<typeof setTimeout> | undefined;
  /**
   * How many times the page could be loaded since the connection was lost. Once does not prove a refusal: the robot
   * may have just restarted.
   */
  private loadCount = 0;
  private awaitsServices = false;
  private awaitsGraph = false;
  private nextSubscriptionId = 1;
  private readonly frame = frameTask(() => this.bumpChanged());

  constructor() {
    this.gateway = new Gateway({
      onConnection: (info, reason) => this.onConnection(info, reason),
      onCommandConnection: (isOpen) => {
        this.canCommand.value = isOpen;
      },
      onChannels: (added, removedIds) => this.onChannels(added.map(Topic.ofChannel), removedIds),
      onServices: (added, removedIds) => this.onServices(added, removedIds),
      onMessage: (id, timeNs, payload) => {
        const feed = this.bySubscription.get(id);
        if (!feed) return;
        feed.receive({ payload, receivedMs: performance.now(), timeNs });
        this.fill(feed);
        this.changed.add(feed);
        this.frame.markDirty();
      },
      onGraph: (update) => this.onGraph(update),
      onParameters: (parameters) => this.parameters.receive(parameters),
      onStatus: (status) => {
        const others = this.statuses.value.filter((each) => each.id === undefined || each.id !== status.id);
        this.statuses.value = [...others, status].slice(-MAX_STATUSES);
      },
      onStatusRemoved: (ids) => {
        this.statuses.value = this.statuses.value.filter((each) => !each.id || !ids.includes(each.id));
      },
      onRefusal: (reason) => {
        this.refusal.value = reason;
        clearTimeout(this.refusalTimer);
        this.refusalTimer = setTimeout(() => {
          this.refusal.value = "";
        }, REFUSAL_MS);
      },
      onRecordings: (recordings) => {
        this.recordings.value = recordings;
      },
      onTime: (timeNs) => {
        this.simulatedTimeNs.value = timeNs;
      },
    });
    this.parameters = new Parameters(this.gateway);
  }

  /** The feed of a topic, which need not exist yet; reading it does not subscribe. */
  feed(topicName: string): Feed {
    let feed = this.feeds.get(topicName);
    if (!feed) {
      feed = new Feed(topicName);
      feed.topic.value = this.topics.peek().get(topicName);
      this.feeds.set(topicName, feed);
    }
    return feed;
  }

  /**
   * Receives a topic until `close`. Panels use `PanelContext.subscribe`, which also stops while they are hidden.
   *
   * @param withLatched whether the listener also needs the latched messages that the last panel has received
   */
  subscribe(topicName: string, listener?: Listener, withLatched = false): Subscription {
    const feed = this.feed(topicName);
    let use = this.uses.get(topicName);
    if (!use) {
      use = { count: 0, subscriptionId: undefined, endTimer: undefined };
      this.uses.set(topicName, use);
    }
    clearTimeout(use.endTimer);
    use.endTimer = undefined;
    // The robot sends latched messages once for each subscription.
    if (withLatched && use.count === 0) this.end(use);
    use.count++;
    if (listener) feed.listeners.add(listener);
    this.begin(feed, use);
    let isOpen = true;
    return {
      feed,
      close: () => {
        if (!isOpen) return;
        isOpen = false;
        if (listener) feed.listeners.delete(listener);
        use.count--;
        if (use.count > 0) return;
        use.endTimer = setTimeout(() => {
          this.end(use);
          this.uses.delete(topicName);
        }, UNSUBSCRIBE_DELAY_MS);
      },
    };
  }

  /** Resolves when every topic that is received has had a message, or after `maxMs`. */
  firstValues(maxMs: number): Promise<void> {
    return new Promise((resolve) => {
      const end = () => {
        clearTimeout(timer);
        this.onNoneEmpty.delete(end);
        resolve();
      };
      const timer = setTimeout(end, maxMs);
      if (this.empty.size === 0) end();
      else this.onNoneEmpty.add(end);
    });
  }

  private fill(feed: Feed): void {
    if (!this.empty.delete(feed) || this.empty.size > 0) return;
    for (const each of [...this.onNoneEmpty]) each();
  }

  /** How many topics are subscribed now; for tests. */
  get subscriptionCount(): number {
    return this.bySubscription.size;
  }

  private begin(feed: Feed, use: Use): void {
    const channelId = feed.topic.peek()?.channelId;
    if (channelId === undefined || use.subscriptionId !== undefined) return;
    // The channel id of a topic from the previous connection may now belong to another topic.
    if (this.connection.peek() !== "open" || this.channels.get(channelId)?.name !== feed.topicName) return;
    use.subscriptionId = this.nextSubscriptionId++;
    feed.rate.start(performance.now());
    this.bySubscription.set(use.subscriptionId, feed);
    if (feed.last === undefined) this.empty.add(feed);
    this.gateway.subscribe([{ id: use.subscriptionId, channelId }]);
  }

  private end(use: Use): void {
    if (use.subscriptionId === undefined) return;
    const feed = this.bySubscription.get(use.subscriptionId);
    if (feed) this.fill(feed);
    this.bySubscription.delete(use.subscriptionId);
    this.gateway.unsubscribe([use.subscriptionId]);
    use.subscriptionId = undefined;
  }

  private onConnection(info: ServerInfo | undefined, reason: string): void {
    this.bySubscription.clear();
    for (const use of this.uses.values()) use.subscriptionId = undefined;
    if (!info) {
      batch(() => {
        this.connection.value = "lost";
        this.lostReason.value = reason;
      });
      if (reason === "") void this.explainLoss();
      return;
    }
    batch(() => {
      this.loadCount = 0;
      this.connection.value = "open";
      this.lostReason.value = "";
      this.info.value = info;
      this.simulatedTimeNs.value = undefined;
      this.statuses.value = [];
      // The old topics and services stay until new ones replace them, so that the page does not flicker.
      this.channels.clear();
      this.awaitsServices = this.awaitsGraph = true;
    });
  }

  /** Sets the reason if the robot refuses the page: it then serves the page, but not the connection. Browsers do not report this. */
  private async explainLoss(): Promise<void> {
    const answer = await fetch(location.pathname, { cache: "no-store" }).catch(() => undefined);
    if (answer?.ok && this.connection.value === "lost" && this.loadCount++ > 0)
      this.lostReason.value = this.info.value ? texts.shell.refused : texts.shell.wantsToken;
  }

  private onChannels(added: Topic[], removedIds: number[]): void {
    for (const id of removedIds) this.channels.delete(id);
    for (const each of added) this.channels.set(each.channelId!, each);
    this.mergeTopics();
  }

  private mergeTopics(): void {
    const topics = new Map(this.unpublished);
    for (const each of this.channels.values()) topics.set(each.name, each);
    batch(() => {
      this.topics.value = topics;
      for (const feed of this.feeds.values()) this.follow(feed, topics.get(feed.topicName));
    });
  }

  /** Gives a feed its current topic; a topic that returned with another channel is subscribed again. */
  private follow(feed: Feed, topic: Topic | undefined): void {
    if (topic === feed.topic.peek()) return;
    feed.topic.value = topic;
    const use = this.uses.get(feed.topicName);
    if (!use) return;
    // The server ends the subscription with its channel.
    if (use.subscriptionId !== undefined) this.bySubscription.delete(use.subscriptionId);
    this.fill(feed);
    use.subscriptionId = undefined;
    if (use.count > 0) this.begin(feed, use);
  }

  private onServices(added: Service[], removedIds: number[]): void {
    const services = new Map(this.awaitsServices ? [] : this.services.value);
    this.awaitsServices = false;
    for (const [name, each] of services) if (removedIds.includes(each.id)) services.delete(name);
    for (const each of added) services.set(each.name, each);
    this.services.value = services;
  }

  private onGraph(update: GraphUpdate): void {
    const isFirst = this.awaitsGraph;
    this.awaitsGraph = false;
    if (isFirst) this.unpublished.clear();
    if (isFirst && this.awaitsServices) this.onServices([], []);
    const publishers = without(isFirst ? NONE : this.publishers.value, update.removedTopics);
    const subscribers = without(isFirst ? NONE : this.subscribers.value, update.removedTopics);
    for (const each of update.publishedTopics) publishers.set(each.name, each.publisherIds);
    for (const name of update.removedTopics) this.unpublished.delete(name);
    for (const { name, subscriberIds, schemaName, schema } of update.subscribedTopics) {
      subscribers.set(name, subscriberIds);
      if (schemaName === undefined || schema === undefined) this.unpublished.delete(name);
      else this.unpublished.set(name, new Topic(name, schemaName, schema, undefined));
    }
    batch(() => {
      this.publishers.value = publishers;
      this.subscribers.value = subscribers;
      this.mergeTopics();
    });
  }

  private bumpChanged(): void {
    const changed = [...this.changed];
    this.changed.clear();
    batch(() => {
      for (const feed of changed) feed.bump();
    });
  }
}

function without(
  table: ReadonlyMap<string, readonly string[]>,
  names: string[],
): Map<string, readonly string[]> {
  const copy = new Map(table);
  for (const name of names) copy.delete(name);
  return copy;
}
