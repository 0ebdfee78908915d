/** Begin: the robot stands in the page as JSON. */

import { App } from "./app.js";
import { Chooser } from "./panels/changes.js";

const data = JSON.parse(document.getElementById("robot").textContent);
window.app = new App(document.getElementById("app"), data);
const { others, ...first } = data;
if (others) new Chooser(window.app, [first, ...others]);
