/** What is above the robot: a mistake of the description. */

import { element } from "../dom.js";

/** Shows that the last save does not compile; the robot below is the one before. */
export class Problem {
  constructor() {
    this.root = element("section", { class: "problem", hidden: true, role: "alert" });
  }

  /** Show what the compiler says; nothing hides it. `alone`: there was no robot yet. */
  show(text, alone = false) {
    const below = alone ? "The robot appears as soon as it does." : "Below is the last robot that did.";
    this.root.hidden = !text;
    this.root.replaceChildren(element("b", {}, `This does not compile. ${below}`), element("pre", {}, text));
  }
}
