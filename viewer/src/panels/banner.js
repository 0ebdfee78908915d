/** What is above the robot: a mistake of the description. */

import { element } from "../dom.js";

/** Shows that the last save does not compile; the robot below is the one before. */
export class Problem {
  constructor() {
    this.root = element("section", { class: "problem", hidden: true, role: "alert" });
  }

  show(text) {
    this.root.hidden = !text;
    this.root.replaceChildren(element("b", {}, "This does not compile. Below is the last robot that did."), element("pre", {}, text));
  }
}
