/** What became of the robot before: the changes, by meaning; a click flies there. And which robot of several is shown. */

import { element } from "../dom.js";
import { inUnits } from "../units.js";
import { swatches } from "./card.js";

const WORDS = { moved: "moved", carried: "carried along", shaped: "other shapes", new: "new", removed: "no more" };
const FULL = 100; // of the slider

/** Return changes with one heading for each frame, in their order; those without a frame come last. */
export function grouped(changes) {
  const groups = new Map();
  for (const change of changes) {
    const frame = change.frame ?? "";
    if (!groups.has(frame)) groups.set(frame, []);
    groups.get(frame).push(change);
  }
  return [...groups].sort(([one], [other]) => Number(!one) - Number(!other));
}

/** Lists what changed. */
export class Changes {
  constructor(app) {
    this.app = app;
    this.root = element("section", { class: "changes", hidden: true });
    this.at = -1;
  }

  draw() {
    const { changes, said, notes, ghost, became } = this.app;
    this.root.hidden = !changes;
    this.at = -1;
    if (!changes) return;
    const groups = grouped(changes);
    this.frames = groups.map(([frame]) => frame).filter(Boolean);
    this.rows = new Map();
    const list = groups.map(([frame, some]) => this.#group(frame, some, became[frame]));
    const more = notes?.length ? element("details", {}, element("summary", { class: "quiet" }, `${notes.length} more to say`), element("ul", { class: "quiet" }, ...notes.map((note) => element("li", {}, note)))) : "";
    this.root.replaceChildren(element("details", { open: true }, element("summary", {}, said ?? `${changes.length} changes`), element("ol", {}, ...list), more, ghost && changes.some(({ frame }) => frame) ? this.#fader() : ""));
  }

  #group(frame, changes, how) {
    const lines = changes.map(({ text, artifacts, colours }) => element("p", {}, swatches(colours), inUnits(text, this.app.units), artifacts ? element("small", {}, ` ${artifacts.join(", ")}`) : ""));
    if (!frame) return element("li", {}, ...lines);
    const go = element("button", { class: "go", title: "look at it (key n: the next one)", onclick: () => this.fly(frame) }, frame);
    const row = element("li", { "data-frame": frame }, go, element("small", {}, how ? ` ${WORDS[how]}` : ""), ...lines);
    this.rows.set(frame, row);
    return row;
  }

  /** A slider from the robot of now alone to the robot before, drawn as if it were there. */
  #fader() {
    const { app } = this;
    const slider = element("input", { type: "range", min: 0, max: 2 * FULL, value: app.ghost.strength * FULL, "aria-label": "how strongly the robot before is drawn", id: "fade" });
    slider.addEventListener("input", () => {
      app.fade(Number(slider.value) / FULL);
    });
    return element("label", { class: "fader", title: "key b: with it or without" }, "now", slider, element("span", { class: "was" }, "before"));
  }

  /** Look at the next frame that changed. */
  next(step = 1) {
    if (!this.frames?.length) return;
    this.fly(this.frames[(this.at + step + this.frames.length) % this.frames.length]);
  }

  /** Look at a frame that changed, as it was and as it is. */
  fly(frame) {
    const { app } = this;
    this.at = this.frames?.indexOf(frame) ?? -1;
    if (!this.rows) return;
    for (const [name, row] of this.rows) row.classList.toggle("here", name === frame);
    const link = app.robot.links.find((one) => one.name === frame);
    if (link && !link.visual.length && link.collision.length) app.show({ collision: true });
    app.fly(frame);
  }
}

/** Chooses one of the robots of a page. */
export class Chooser {
  constructor(app, entries) {
    const names = entries.map(({ robot, changes }) => `${robot.name}${changes?.length ? ` (${changes.length} changed)` : ""}`);
    this.list = element("select", { "aria-label": "robot", id: "robot-choice", onchange: () => show(entries[this.list.selectedIndex]) });
    for (const name of names) this.list.append(element("option", {}, name));
    app.title.after(this.list);
    const show = (entry) => {
      app.select("");
      app.load(entry, true);
    };
    const asked = new URLSearchParams(window.location.hash.slice(1)).get("robot");
    const index = entries.findIndex(({ robot }) => robot.name === asked);
    if (index > 0) {
      this.list.selectedIndex = index;
      show(entries[index]);
    }
  }
}
