/** What is above the robot: a mistake of the description, what changed, and what cannot be told. */

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

/** Lists what moved, by meaning; a click flies there. */
export class Changes {
  constructor(app) {
    this.app = app;
    this.root = element("section", { class: "changes", hidden: true });
  }

  draw() {
    const { changes } = this.app;
    this.root.hidden = !changes;
    if (!changes) return;
    const rows = changes.map(({ text, frame }) =>
      element("li", frame ? { class: "link", onclick: () => this.app.fly(frame) } : {}, text),
    );
    const said = changes.length === 1 ? "1 change" : `${changes.length || "no"} changes`;
    this.root.replaceChildren(element("details", { open: true }, element("summary", {}, said), element("ul", {}, ...rows)));
  }
}
