import "./shell/theme.ts";
import { render } from "preact";
import { keepToken } from "./connection/address.ts";
import { releaseWhenHidden } from "./panels/drive/drivers.ts";
import { App } from "./shell/app.tsx";
import { Robot } from "./store/robot.ts";

keepToken();
releaseWhenHidden();
const robot = new Robot();
// For tests and for developers: `rostether.subscriptionCount`.
Object.assign(globalThis, { rostether: robot });
render(<App robot={robot} />, document.getElementById("app")!);
