/** The card of what is chosen: what it is, its numbers, the lines that say so; and the way between two frames. */

import { copy, dot, element } from "../dom.js";
import { position } from "../kinematics.js";
import { explained } from "../live.js";
import { inverse, rpy, then } from "../transform.js";
import { UNITS, angle, kindOf, length, plain, vector } from "../units.js";

/** Return two colours as spots: what was, and what is; nothing for a change of something else. */
export function swatches(colours) {
  const spot = (rgba) => dot(rgba ? `rgb(${rgba.slice(0, 3).map((part) => Math.round(255 * part)).join(" ")} / ${rgba[3]})` : "transparent");
  return colours ? element("span", { class: "swatches", title: "the colour before, and that of now" }, spot(colours.was), "→", spot(colours.is)) : "";
}

function row(name, ...value) {
  return value.some(Boolean) ? element("tr", {}, element("th", {}, name), element("td", {}, ...value)) : "";
}

/** Return a place in a description: it opens in the editor, or is copied. */
export function place(where) {
  if (!where) return "";
  const name = `${where.file}:${where.line}`;
  const button = element("button", { class: "place", title: "copy", onclick: (event) => copy(name, event.currentTarget) }, name);
  const link = where.path && element("a", { href: `vscode://file${encodeURI(where.path)}:${where.line}:${where.column}`, title: "open in the editor" }, "open");
  return element("span", {}, button, " ", link ?? "");
}

const HALF_TURN = 1e-9 - Math.PI;
const COMPONENTS = { xyz: "x y z", rpy: "roll pitch yaw" };
const PLACE = /^(.+?):(\d+):(\d+)(: .*)?$/;

/** Return a cell of an explanation: a place in a file as a link, all else as text. */
function cell(text, folder) {
  const [, file, line, column, rest] = PLACE.exec(text) ?? [];
  if (!file) return [text];
  const path = folder === null || file.startsWith("/") ? undefined : `${folder}${file}`;
  return [place({ file, line: Number(line), column: Number(column), path }), rest ?? ""];
}

/** Return the heading of a vector, and its numbers as one text with the names of the components. */
function components([title, ...numbers]) {
  const [, heading, names] = /^(\w+) (x y z w)$/.exec(title) ?? [null, title, COMPONENTS[title]];
  return [heading, numbers.map((number, index) => `${names.split(" ")[index]} ${number}`).join(", ")];
}

/** Return the lines of an explanation laid out: headings, sentences, and tables of values with their places. */
export function laidOut(lines, folder) {
  const made = [];
  let [table, title] = [null, ""];
  for (const line of lines) {
    let cells = line.trim().split(/\s{2,}/);
    const depth = line.length - line.trimStart().length;
    if (!line.trim()) table = null;
    else if (cells.length > 1) {
      if (!table) made.push((table = element("table", {})));
      if (Number.isFinite(Number(cells[0]))) cells.unshift(title); // the row above in another unit
      [title] = cells;
      const isVector = title in COMPONENTS || title.endsWith(" x y z w");
      if (isVector) cells = components(cells);
      table.append(element("tr", {}, element("th", {}, cells[0]), ...cells.slice(1).map((text) => element("td", { colspan: isVector && 3 }, ...cell(text, folder)))));
    } else {
      table = null;
      made.push(element(depth ? "p" : "h2", { style: `margin-left:${Math.min(depth, 6)}ch` }, ...cell(line.trim(), folder)));
    }
  }
  return made;
}

/** Shows one frame, and measures from it to another. */
export class Card {
  constructor(app) {
    this.app = app;
    this.root = element("aside", { class: "card", hidden: true, "aria-live": "polite" });
    this.from = "";
    this.changing = [];
  }

  /** Renew the numbers that follow the joints. */
  update() {
    if (this.root.hidden) return;
    for (const { cell, text } of this.changing) cell.textContent = text();
  }

  /** Return a row whose value follows the joints. */
  #moving(name, text) {
    const cell = element("td", {}, text());
    this.changing.push({ cell, text });
    return element("tr", {}, element("th", {}, name), cell);
  }

  draw() {
    const { app } = this;
    this.changing = [];
    const { robot, selected: name } = app;
    if (!app.places?.has(this.from)) this.from = "";
    this.root.hidden = !name;
    if (!name) return;
    const link = robot.links.find((one) => one.name === name);
    const joint = robot.joints.find((one) => one.child === name);
    const sensor = robot.sensors.find((one) => one.frame === name || one.optical_frame === name);
    const close = () => {
      this.from = "";
      app.select("");
    };
    const head = element("header", {}, element("b", {}, name), element("button", { class: "close", "aria-label": "close", onclick: close }, "×"));
    const body = link
      ? [...this.#link(link), ...this.#joint(joint), ...this.#publishers(name), row("source", joint?.source), ...this.#sensor(sensor), ...this.#measured(name)]
      : this.#publishers(name);
    const foreign = link ? "" : element("p", { class: "quiet" }, "a frame of another node: only that one knows where it is");
    this.root.replaceChildren(head, element("table", {}, ...body), foreign, this.#chain(link), this.#tools(link));
  }

  /** The lines of the description that put the frame where it is; a live page asks for them when it is unfolded. */
  #chain(link) {
    if (!link || (!link.said && !document.body.dataset.live)) return "";
    const { where } = link;
    const folder = where?.path?.endsWith(where.file) ? where.path.slice(0, -where.file.length) : null;
    const said = (link.said ?? []).map((index) => this.app.robot.lines[index]);
    const lines = element("div", {}, ...laidOut(said, folder));
    const ask = async () => {
      if (!lines.children.length) lines.replaceChildren(...laidOut(await explained(link.name), folder));
      if (!lines.children.length) lines.append("nothing is known of it");
    };
    const units = element("p", { class: "quiet" }, "values are in m, rad and kg, whatever units the page shows");
    return element("details", { class: "chain", ontoggle: ask }, element("summary", {}, "where this comes from"), units, lines);
  }

  #link(link) {
    const { units } = this.app;
    const { inertial } = link;
    const kinds = ["visual", "collision"].map((key) => link[key].length && `${link[key].length} ${key}`).filter(Boolean);
    return [
      row("defined at", place(link.where)),
      row("mass", inertial && `${Number(inertial.mass.toPrecision(6))} kg at ${vector(inertial.xyz, units)}`),
      row("shapes", kinds.join(", ")),
      row("colour", swatches(this.app.coloured.get(link.name))),
    ];
  }

  #joint(joint) {
    if (!joint) return [];
    const { units } = this.app;
    const kind = joint.type === "prismatic" ? length : angle;
    const { lower, upper } = joint.limit ?? {};
    return [
      row("joint", `${joint.name}, ${joint.type} in ${joint.parent}`),
      row("origin", `${vector(joint.xyz, units)}; ${vector(joint.rpy, units, "angle")}`),
      ...(joint.axis && joint.type !== "planar" ? [this.#moving("position", () => this.#position(joint))] : []),
      ...(joint.type === "fixed" ? [] : [this.#moving("now", () => this.#way(joint.parent, joint.child))]),
      row("limits", Number.isFinite(lower) && `${kind(lower, units)} to ${kind(upper, units)}`),
      row("follows", joint.mimic && `${joint.mimic.multiplier} × ${joint.mimic.joint}${joint.mimic.offset ? ` + ${kind(joint.mimic.offset, units)}` : ""}`),
    ];
  }

  /** Return a row for each publisher of the frame; a frame can have several parents. */
  #publishers(name) {
    const edges = this.app.edgesTo(name);
    const inParent = ({ parent, joint }) => (joint && edges.length === 1 ? "" : ` (in ${parent})`); // a joint names its parent
    const who = ({ published, publisher, topic, why }) => (published ? `${publisher}, ${topic}` : `nobody${why ? `: ${why}` : ""}`);
    return edges.map((edge) => row("publisher", who(edge) + inParent(edge)));
  }

  /** Return the position of a joint of one coordinate as its number box has it; followers have no box. */
  #position(joint) {
    const { state, kinematics, units } = this.app;
    return plain(position(joint, state, kinematics.byName), UNITS[units][kindOf(joint.type)]);
  }

  #sensor(sensor) {
    return sensor ? [row("sensor", `${sensor.name}, ${sensor.type}`)] : [];
  }

  #measured(name) {
    const { from } = this;
    if (!from || from === name || !this.app.places.has(from)) return [];
    const apart = () => length(Math.hypot(...this.#between(from, name).p), this.app.units);
    return [row("in", from), this.#moving("", () => this.#way(from, name)), this.#moving("apart", apart)];
  }

  #between(source, target) {
    const { places } = this.app;
    return then(inverse(places.get(source)), places.get(target));
  }

  /** Return the way from one frame to another in words, at the joint positions of now; half a turn is 180 deg, never -180. */
  #way(source, target) {
    const between = this.#between(source, target);
    const angles = rpy(between).map((turn) => (turn < HALF_TURN ? Math.PI : turn));
    return `${vector(between.p, this.app.units)}; ${vector(angles, this.app.units, "angle")}`;
  }

  /** Measure from a frame to each frame that is selected next; with "", stop measuring. */
  measure(from) {
    this.from = from;
    this.draw();
  }

  #tools(link) {
    const { from, app } = this;
    if (!link && !from) return "";
    const hint = from === app.selected ? "select another frame to measure to it" : from ? `stop measuring from ${from}` : "measure from here";
    const title = "measure from this frame to each frame that you select next, in the picture or in the tree; Escape or this button ends it";
    const measure = element("button", { class: from ? "on" : "", id: "measure", title, onclick: () => this.measure(from ? "" : link.name) }, hint);
    return element("footer", {}, measure, link && element("button", { onclick: () => app.fly(link.name) }, "fly there"));
  }
}
