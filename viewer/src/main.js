/** Begin: the robot stands in the page as JSON. */

import { App } from "./app.js";

const data = JSON.parse(document.getElementById("robot").textContent);
window.app = new App(document.getElementById("app"), data);
