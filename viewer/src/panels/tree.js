/** The tree of frames, with who publishes each. */

import { dot, element } from "../dom.js";

/** Return the situation that holds for a set of modes: its edges are those that are published then. */
export function situationFor(robot, modes) {
  const fits = (one) => Object.entries(one).every(([mode, on]) => Boolean(modes[mode]) === on);
  return robot.situations.find((situation) => situation.modes.some(fits)) ?? robot.situations[0] ?? null;
}

const ROLLERS = 3; // links that turn freely on one link, from which on they are folded under it

/** Return the edges of all frames: those of a situation, and the joints of links that are in none, as of simulations. */
export function edgesOf(robot, modes) {
  const edges = situationFor(robot, modes)?.edges ?? [];
  const children = new Set(edges.map((edge) => edge.child));
  const others = robot.joints.filter((joint) => !children.has(joint.child) && !edges.some(({ parent }) => parent === joint.child));
  return [...edges, ...others.map(({ parent, child, name, type }) => ({ parent, child, joint: name, kind: type, published: false, why: "no node of this robot publishes it" }))];
}

/** Return a name that is broken behind its underscores, if there is no room for it in one line. */
function breakable(name) {
  return name.split(/(?<=[_/.-])/).flatMap((part) => [element("wbr"), part]).slice(1);
}

/**
 * Return the joints of passive rollers by the wheel that carries them: three or more that turn without limits and carry
 * nothing, on a link that turns as well (the wheels of a base are not rollers).
 */
export function rollersByWheel({ joints }) {
  const carrying = new Set(joints.map((joint) => joint.parent));
  const turning = joints.filter(({ type }) => type === "continuous");
  const wheels = new Map(turning.map(({ child }) => [child, []]));
  for (const joint of turning) if (!carrying.has(joint.child)) wheels.get(joint.parent)?.push(joint);
  return new Map([...wheels].filter(([, rollers]) => rollers.length >= ROLLERS));
}

/** Shows the frames of a robot as a tree; a click chooses one, and so do the arrows of the keyboard with Enter. */
export class Tree {
  constructor(app) {
    this.app = app;
    this.search = element("input", { type: "search", placeholder: "find a frame ( / )", "aria-label": "find a frame", oninput: () => this.filter(), onkeydown: (event) => event.key === "Enter" && this.#first() });
    const over = (event) => this.app.hover(event.target.closest?.(".row")?.dataset.frame ?? "");
    this.list = element("ul", { class: "tree", role: "tree", "aria-label": "frames", onkeydown: (event) => this.#key(event), onclick: (event) => this.#click(event), onmouseover: over, onmouseleave: () => this.app.hover("") });
    this.nothing = element("p", { class: "quiet", role: "status", hidden: true }, "no frame or joint has this name");
    this.root = element("div", { class: "pane" }, this.search, this.list, this.nothing);
    this.folded = null;
  }

  /** Draw the tree that holds for the modes of now; what was folded stays so. */
  draw() {
    const { robot, modes } = this.app;
    if (this.robotName !== robot.name) this.folded = new Set(rollersByWheel(robot).keys());
    this.robotName = robot.name;
    const edges = edgesOf(robot, modes);
    const below = new Map();
    const children = new Set(edges.map((edge) => edge.child));
    for (const edge of edges) {
      if (!below.has(edge.parent)) below.set(edge.parent, []);
      below.get(edge.parent).push(edge);
    }
    const tops = [...new Set([...below.keys(), robot.root])].filter((name) => !children.has(name));
    this.rows = new Map(); // of a frame with several parents, the first one
    this.nodes = [];
    const waiting = tops.reverse().map((name) => [name, null, -1]);
    while (waiting.length) {
      const [name, edge, above] = waiting.pop();
      const again = this.rows.has(name);
      const depth = above < 0 ? 0 : this.nodes[above].depth + 1;
      const next = again ? [] : (below.get(name) ?? []);
      const row = this.#row(name, edge, depth, next.length > 0);
      if (!again) this.rows.set(name, row);
      this.nodes.push({ name, row, above, depth, text: `${name} ${edge?.joint ?? ""} ${edge?.kind ?? ""}`.toLowerCase() });
      const here = this.nodes.length - 1;
      waiting.push(...next.map((one) => [one.child, one, here]).reverse());
    }
    this.list.replaceChildren();
    this.marked = new Set();
    this.filter();
    this.mark();
    this.nodes[0]?.row.setAttribute("tabindex", "0");
  }

  #row(name, edge, depth, unfolds) {
    const colour = edge?.published ? this.app.robot.publishers[edge.publisher] : "transparent";
    const by = edge?.published ? `published by ${edge.publisher} on ${edge.topic}` : `published by nobody${edge?.why ? `: ${edge.why}` : ""}`;
    const joint = [edge?.joint, edge?.kind].filter(Boolean).join(", ");
    const title = edge ? [`${edge.parent} → ${edge.child}`, joint, by].filter(Boolean).join("\n") : name;
    return element(
      "li",
      { class: edge && !edge.published ? "row unpublished" : "row", role: "treeitem", tabindex: "-1", title, "data-frame": name, "data-parent": edge?.parent, "aria-level": depth + 1, "aria-expanded": unfolds ? String(!this.folded.has(name)) : undefined, style: `--depth:${depth}` },
      element("i", { class: unfolds ? "twist" : "twist none", "aria-hidden": "true" }),
      dot(colour),
      element("span", {}, ...breakable(name)),
      edge?.joint && edge.kind !== "fixed" && element("small", {}, edge.kind),
    );
  }

  #click(event) {
    const row = event.target.closest(".row");
    if (!row) return;
    if (event.target.matches(".twist:not(.none)")) this.fold(row.dataset.frame);
    else this.#choose(row);
  }

  /** Select the frame of a row, and mark this row if the frame has several parents. */
  #choose(row) {
    this.chosen = { name: row.dataset.frame, parent: row.dataset.parent };
    this.app.select(row.dataset.frame);
  }

  /** Return the row of the chosen frame. */
  get #selected() {
    const { selected } = this.app;
    const isChosen = ({ row: { dataset } }) => dataset.frame === selected && dataset.parent === this.chosen.parent;
    return (this.chosen?.name === selected && this.nodes.find(isChosen)?.row) || this.rows.get(selected);
  }

  #key(event) {
    const rows = [...this.list.children];
    const row = document.activeElement;
    const at = rows.indexOf(row);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: rows.length - 1 }[event.key];
    const folds = { ArrowLeft: "true", ArrowRight: "false" }[event.key];
    if (event.key === "Enter" || event.key === " ") this.#choose(row);
    else if (folds) row.getAttribute("aria-expanded") === folds && this.fold(row.dataset.frame);
    else if (to === undefined) return;
    else rows[to]?.focus();
    event.preventDefault();
    event.stopPropagation();
  }

  /** Fold what hangs on a frame, or unfold it. */
  fold(name) {
    if (!this.folded.delete(name)) this.folded.add(name);
    this.rows.get(name).setAttribute("aria-expanded", String(!this.folded.has(name)));
    this.filter();
  }

  /** Show only frames that match the search by their name, joint or joint type; without a search, those that are not folded. */
  filter() {
    const focused = this.list.contains(document.activeElement) ? document.activeElement : null;
    const wanted = this.search.value.trim().toLowerCase();
    this.list.classList.toggle("found", Boolean(wanted)); // without the levels of the tree
    const closed = [];
    const shown = [];
    let deepest = 1;
    this.nodes?.forEach(({ name, row, above, depth, text }, index) => {
      const inside = above >= 0 && closed[above];
      closed[index] = inside || this.folded.has(name);
      const hidden = wanted ? !text.includes(wanted) : Boolean(inside);
      row.hidden = hidden;
      if (hidden) return;
      shown.push(row);
      deepest = Math.max(deepest, depth);
    });
    this.nothing.hidden = !wanted || shown.length > 0;
    this.list.style.setProperty("--deepest", deepest);
    this.list.replaceChildren(...shown); // thousands of hidden rows would cost time at each change
    focused?.focus();
  }

  /** Select the best match and fly to it: a name that begins with the text, or contains it, or a frame found by its joint. */
  #first() {
    const wanted = this.search.value.trim().toLowerCase();
    const found = this.nodes.filter(({ row }) => !row.hidden).map(({ name }) => name);
    const at = (name) => name.toLowerCase().indexOf(wanted);
    const first = found.find((name) => at(name) === 0) ?? found.find((name) => at(name) > 0) ?? found[0];
    if (first && wanted) this.app.fly(first);
  }

  mark() {
    if (!this.rows) return;
    for (const row of this.marked) row.classList.remove("selected", "touching");
    const touching = [...this.app.touching].map((name) => this.rows.get(name)).filter(Boolean);
    const selected = [this.#selected].filter(Boolean);
    for (const row of touching) row.classList.add("touching");
    for (const row of selected) row.classList.add("selected");
    this.marked = new Set([...touching, ...selected]);
  }

  /** Unfold the way to the chosen frame, and scroll there. */
  reveal() {
    const row = this.rows && this.#selected;
    let at = this.nodes?.find((node) => node.row === row);
    if (!at) return;
    for (at = this.nodes[at.above]; at; at = this.nodes[at.above]) if (this.folded.has(at.name)) this.fold(at.name);
    row.scrollIntoView({ block: "nearest" });
  }
}
