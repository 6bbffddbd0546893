// Makes a Preact component a panel.
import { type ComponentType, render } from "preact";
import type { PanelContext, PanelModule } from "./panel.ts";

export function preactPanel(Component: ComponentType<{ context: PanelContext }>): PanelModule {
  return {
    mount(host, context) {
      render(<Component context={context} />, host);
      return () => render(null, host);
    },
  };
}
