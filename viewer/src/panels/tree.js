/** The tree of frames, with who publishes each. */

import { dot, element } from "../dom.js";

/** Return the situation that holds for a set of modes: its edges are those that are published then. */
export function situationFor(robot, modes) {
  const fits = (one) => Object.entries(one).every(([mode, on]) => Boolean(modes[mode]) === on);
  return robot.situations.find((situation) => situation.modes.some(fits)) ?? robot.situations[0] ?? null;
}

const DEEPEST = 9; // levels that are indented: below, frames would leave the panel

/** Shows the frames of a robot as a tree; a click chooses one, and so do the arrows of the keyboard with Enter. */
export class Tree {
  constructor(app) {
    this.app = app;
    this.search = element("input", { type: "search", placeholder: "find a frame ( / )", oninput: () => this.filter() });
    this.list = element("ul", { class: "tree", role: "tree", "aria-label": "frames", onkeydown: (event) => this.#key(event) });
    this.root = element("div", { class: "pane" }, this.search, this.list);
  }

  /** Draw the tree that holds for the modes of now. */
  draw() {
    const { robot, modes } = this.app;
    const edges = situationFor(robot, modes)?.edges ?? [];
    const below = new Map();
    const children = new Set(edges.map((edge) => edge.child));
    for (const edge of edges) {
      if (!below.has(edge.parent)) below.set(edge.parent, []);
      below.get(edge.parent).push(edge);
    }
    const tops = [...new Set([...below.keys(), robot.root])].filter((name) => !children.has(name));
    this.rows = new Map();
    const seen = new Set();
    this.list.replaceChildren(...tops.map((name) => this.#row(name, null, below, seen, 0)).flat());
    this.filter();
    this.mark();
    this.list.firstChild?.setAttribute("tabindex", "0");
  }

  #key(event) {
    const rows = [...this.list.children].filter((row) => !row.hidden);
    const at = rows.indexOf(document.activeElement);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: rows.length - 1 }[event.key];
    if (event.key === "Enter" || event.key === " ") document.activeElement.click();
    else if (to === undefined) return;
    else rows[to]?.focus();
    event.preventDefault();
    event.stopPropagation();
  }

  #row(name, edge, below, seen, depth) {
    const colour = edge?.published ? this.app.robot.publishers[edge.publisher] : "transparent";
    const title = edge ? `${edge.parent} → ${edge.child}\n${edge.published ? `published by ${edge.publisher} on ${edge.topic}` : `published by nobody${edge.why ? `: ${edge.why}` : ""}`}` : "";
    const row = element(
      "li",
      { class: edge && !edge.published ? "row unpublished" : "row", role: "treeitem", tabindex: "-1", title, "aria-level": depth + 1, style: `--depth:${Math.min(depth, DEEPEST)}`, onclick: () => this.app.select(name), onmouseenter: () => this.app.hover(name), onmouseleave: () => this.app.hover("") },
      dot(colour),
      element("span", {}, name),
      edge?.joint && edge.kind !== "fixed" && element("small", {}, edge.kind),
    );
    if (!this.rows.has(name)) this.rows.set(name, row);
    if (seen.has(name)) return [row];
    seen.add(name);
    return [row, ...(below.get(name) ?? []).flatMap((next) => this.#row(next.child, next, below, seen, depth + 1))];
  }

  /** Show only frames whose names hold what is searched for. */
  filter() {
    const wanted = this.search.value.trim().toLowerCase();
    for (const row of this.list.children) row.hidden = wanted && !row.textContent.toLowerCase().includes(wanted);
  }

  mark() {
    const { selected, touching } = this.app;
    for (const [name, row] of this.rows ?? []) {
      row.classList.toggle("selected", name === selected);
      row.classList.toggle("touching", touching.has(name));
    }
  }

  /** Scroll to the chosen frame. */
  reveal() {
    this.rows?.get(this.app.selected)?.scrollIntoView({ block: "nearest" });
  }
}
