// The frame around the panels: header, navigation, and the panel that the address names.
import { computed, useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { graphOf } from "../panels/graph_of.ts";
import type { Panel } from "../panels/panel.ts";
import { panelGroups, panels } from "../panels/registry.ts";
import type { Robot } from "../store/robot.ts";
import { texts } from "../texts.ts";
import { Header } from "./header.tsx";
import { Icon } from "./icons.tsx";
import { Overview } from "./overview.tsx";
import { PanelPage } from "./panel_page.tsx";
import { linkTo, route } from "./route.ts";

const TAB_COUNT = 4;

export function App({ robot }: { robot: Robot }) {
  const useful = useMemo(
    () =>
      computed(() =>
        panelGroups.map((group) => group.filter((each) => each.isUseful?.(graphOf(robot)) ?? true)),
      ),
    [robot],
  );
  const panel = panels.find((each) => each.id === route.value.panelId);
  useEffect(() => {
    const name = robot.info.value?.name;
    document.title = [panel && texts.panels[panel.title], name, "rostether"].filter(Boolean).join(" · ");
  });
  return (
    <div class="app">
      {/* Not a link: its address would replace that of the panel. */}
      <button type="button" class="skip" onClick={() => document.getElementById("content")?.focus()}>
        {texts.shell.skip}
      </button>
      <Header robot={robot} />
      <Navigation groups={useful.value} active={panel?.id ?? ""} />
      <main id="content" tabIndex={-1} class={panel?.fillsPage ? "content fills" : "content"}>
        {panel ? <PanelPage key={panel.id} panel={panel} robot={robot} /> : <Overview robot={robot} />}
      </main>
    </div>
  );
}

function Navigation({ groups, active }: { groups: Panel[][]; active: string }) {
  const isOpen = useSignal(false);
  const tabs = groups
    .flat()
    .filter((each) => each.onTabBar)
    .slice(0, TAB_COUNT - 1);
  const isTab = (panel: Panel) => tabs.includes(panel);
  return (
    <nav class={isOpen.value ? "navigation open" : "navigation"} aria-label={texts.shell.navigation}>
      <NavigationLink id="" title="overview" icon="overview" isActive={active === ""} isTab />
      {groups.map((group) =>
        group.map((each, index) => (
          <NavigationLink
            key={each.id}
            id={each.id}
            title={each.title}
            icon={each.icon}
            isActive={active === each.id}
            isTab={isTab(each)}
            isFirst={index === 0}
            onOpen={() => {
              isOpen.value = false;
            }}
          />
        )),
      )}
      <button
        type="button"
        class="more"
        aria-current={active !== "" && !tabs.some((each) => each.id === active) ? "page" : undefined}
        aria-expanded={isOpen.value}
        onClick={() => {
          isOpen.value = !isOpen.value;
        }}
      >
        <Icon name={isOpen.value ? "close" : "more"} />
        <span>{texts.shell.more}</span>
      </button>
    </nav>
  );
}

function NavigationLink(props: {
  id: string;
  title: Panel["title"];
  icon: Panel["icon"];
  isActive: boolean;
  isTab: boolean;
  /** Whether it is the first of its group. */
  isFirst?: boolean;
  onOpen?: () => void;
}) {
  const classes = [props.isTab && "tab", props.isFirst && "first"].filter(Boolean).join(" ");
  return (
    <a
      href={linkTo(props.id)}
      class={classes || undefined}
      aria-current={props.isActive ? "page" : undefined}
      onClick={props.onOpen}
    >
      <Icon name={props.icon} />
      <span>{texts.panels[props.title]}</span>
    </a>
  );
}
