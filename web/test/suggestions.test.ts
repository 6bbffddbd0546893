// The cards of the overview without configuration.
import assert from "node:assert/strict";
import { test } from "node:test";
import { boardsPanel } from "../src/panels/boards/boards.ts";
import { controllableTopics } from "../src/panels/controls/controllable.ts";
import { drivableTopics } from "../src/panels/drive/drivable.ts";
import type { Graph } from "../src/panels/panel.ts";
import { plotSuggestions } from "../src/panels/plots/suggestions.ts";
import { simulationPanel } from "../src/panels/simulation/simulation.ts";
import { Topic } from "../src/store/topics.ts";

function graph(topics: Topic[], publishers: [string, string[]][], subscribers: [string, string[]][]): Graph {
  return {
    topics: new Map(topics.map((each) => [each.name, each])),
    publishers: new Map(publishers),
    subscribers: new Map(subscribers),
    services: new Map(),
    ownNodes: ["/page"],
    hasBoards: false,
  };
}

test("a topic that only the page publishes has a control and no plot", () => {
  const servo = new Topic("/servo", "std_msgs/UInt16", "uint16 data", 1);
  const count = new Topic("/count", "std_msgs/UInt16", "uint16 data", 2);
  const found = plotSuggestions(
    graph(
      [servo, count],
      [
        ["/servo", ["/page"]],
        ["/count", ["/board"]],
      ],
      [
        ["/servo", ["/board"]],
        ["/count", ["/page"]],
      ],
    ),
  );
  assert.deepEqual(
    found.map((each) => each.key),
    ["/count"],
  );
  // Its board was unplugged.
  assert.deepEqual(plotSuggestions(graph([servo], [["/servo", ["/page"]]], [])), []);
});

test("a topic that other dashboards publish keeps its control", () => {
  const servo = new Topic("/servo", "std_msgs/UInt16", "uint16 data", 1);
  const with_ = (publisher: string) =>
    graph([servo], [["/servo", ["/page", publisher]]], [["/servo", ["/board", "/dashboard_8766"]]]);
  for (const name of ["/dashboard", "/lab/dashboard_8766", "/web_teleop_8766"]) {
    assert.deepEqual(controllableTopics(with_(name)), ["/servo"]);
    assert.deepEqual(plotSuggestions(with_(name)), []);
  }
  assert.deepEqual(controllableTopics(with_("/my_dashboard")), []);
  assert.deepEqual(
    controllableTopics(graph([servo], [["/servo", ["/page"]]], [["/servo", ["/dashboard_8766"]]])),
    [],
  );
});

test("the number of rosbridge's clients has no plot", () => {
  const count = new Topic("/client_count", "std_msgs/Int32", "int32 data", 1);
  assert.deepEqual(plotSuggestions(graph([count], [["/client_count", ["/rosbridge_websocket"]]], [])), []);
});

test("a plot of one field of several names it", () => {
  const soil = new Topic("/soil", "garden/Soil", "string label\nuint8 state\nfloat32[4] levels", 1);
  const [card] = plotSuggestions(graph([soil], [["/soil", ["/board"]]], []));
  assert.deepEqual([card!.key, card!.title], ["/soil", "/soil/state"]);
});

test("the card of the boards remains after the last one has left", () => {
  const empty = graph([], [], []);
  assert.equal(boardsPanel.matches!(empty).length, 0);
  assert.equal(boardsPanel.matches!({ ...empty, hasBoards: true }).length, 1);
});

test("a simulated board has a card", () => {
  const state = new Topic("/sonar_simulation/state", "std_msgs/String", "string data", 1);
  const [card] = simulationPanel.matches!(graph([state], [], []));
  assert.deepEqual([card!.title, card!.settings], ["/sonar", { topic: state.name }]);
});

test("a command that only the page receives drives nothing", () => {
  const topics = ["/cmd_vel", "/other"].map((name) => new Topic(name, "geometry_msgs/Twist", "", 1));
  const subscribers: [string, string[]][] = [
    ["/cmd_vel", ["/page"]],
    ["/other", ["/base", "/page"]],
  ];
  assert.deepEqual(drivableTopics(graph(topics, [["/cmd_vel", ["/teleop"]]], subscribers)), ["/other"]);
});
