/** What is drawn, from where, in which units and colours. */

import { COLLISION, GHOST, SELECTED, TOUCHING } from "../colours.js";
import { copy, dot, element, section, toggle } from "../dom.js";
import { AXES, MARKS } from "../overlays.js";
import { VIEWS } from "../stage.js";
import { UNITS } from "../units.js";

const LAYERS = {
  visual: ["visuals", "v"],
  collision: ["collision shapes", "c"],
  sensors: ["what sensors see", "s"],
  masses: ["masses and inertia", "m"],
};
export const PAGE_THEMES = { auto: "as the system", light: "light", dark: "dark" };
const FRAMES = { none: "no frames", published: "published frames", all: "all frames", chosen: "the chosen frame" };

function choice(label, options, value, onchange) {
  const list = element("select", { "aria-label": label, onchange: () => onchange(list.value) });
  for (const [key, text] of Object.entries(options)) list.append(element("option", { value: key, selected: key === value }, text));
  return element("label", { class: "choice" }, label, list);
}

/** Return the meaning of colours and markers: coloured dots, each with a text. */
function legend({ robot, before }) {
  const css = (number) => `#${number.toString(16).padStart(6, "0")}`;
  const entries = [
    ...["x", "y", "z"].map((axis, index) => [AXES[index], `axis ${axis} of a frame`]),
    [MARKS.sensor[0], "a sensor"],
    [MARKS.empty[0], "a frame without shapes"],
    [SELECTED, "the selected part"],
    [TOUCHING, "parts that touch each other"],
    [COLLISION, "collision shapes over visuals"],
    ...(before ? [[GHOST, "the robot before"]] : []),
  ];
  const list = (title, spots) => [element("h2", {}, title), element("ul", {}, ...spots.map(([colour, text]) => element("li", {}, dot(colour), element("span", {}, text))))];
  const publishers = Object.entries(robot.publishers).map(([name, colour]) => [colour, name]);
  return [...list("In the picture", entries.map(([colour, text]) => [css(colour), text])), ...(publishers.length ? list("In the tree: publishers of frames", publishers) : [])];
}

const WORDS = {
  "Names in italics": "no node of the robot publishes the frame.",
  "Stand-in": "this value is not measured yet.",
  "Mouse": "drag to rotate, right-drag to move, scroll to zoom.",
  "Keys": "f frames, h home view, / search, n and N next and previous change, Escape ends measuring or clears the selection.",
};

/** The panel of looks. */
export class Look {
  constructor(app) {
    this.app = app;
    this.root = element("div", { class: "pane" });
    this.touching = element("p", { class: "quiet", id: "touching" });
  }

  draw() {
    const { app } = this;
    const layers = Object.entries(LAYERS).map(([name, [label, key]]) => {
      const missing = { sensors: !app.robot.sensors.length && "sensors", visual: !app.robot.links.some(({ visual }) => visual.length) && "visuals" }[name];
      const title = missing ? `this robot has no ${missing}` : `key ${key}`;
      return toggle(label, app.shown[name], (on) => app.show({ [name]: on }), { id: `show-${name}`, title, disabled: Boolean(missing) });
    });
    const views = Object.keys(VIEWS).map((view, index) =>
      element("button", { onclick: () => app.lookFrom(view), title: `key ${index + 1}`, "data-view": view }, view),
    );
    const old = app.before && toggle("the robot before", app.shown.before, (on) => app.show({ before: on }), { id: "show-before", title: "key b" });
    const units = Object.fromEntries(Object.keys(UNITS).map((name) => [name, name]));
    this.root.replaceChildren(
      section("Show", ...layers, old ?? "", choice("frames", FRAMES, app.shown.frames, (frames) => app.show({ frames })), this.touching),
      section("Look from", element("div", { class: "buttons" }, ...views)),
      section("Page", choice("units", units, app.units, (value) => app.use({ units: value })), choice("theme", PAGE_THEMES, app.theme, (value) => app.use({ theme: value })), element("div", { class: "buttons" }, element("button", { id: "copy-link", title: "to this page, as it is now", onclick: (event) => copy(app.address(), event.currentTarget) }, "copy link"))),
      section("Help", element("div", { class: "legend" }, ...legend(app), ...Object.entries(WORDS).map(([word, text]) => element("p", {}, element("b", {}, word), `: ${text}`)))),
    );
  }

  /** Say which parts touch, or why that is not known. */
  tell() {
    this.touching.textContent = this.app.touchingSaid;
  }
}

/** Keys of the keyboard, by what they do. */
export function onKey(app, event) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.("input[type=search]")) return;
  if (event.key !== "/" && event.target.matches?.("input[type=number], select")) return;
  const layer = Object.entries(LAYERS).find(([, [, key]]) => key === event.key);
  const view = Object.keys(VIEWS)[Number(event.key) - 1];
  if (layer) app.show({ [layer[0]]: !app.shown[layer[0]] });
  else if (event.key === "f") app.show({ frames: Object.keys(FRAMES)[(Object.keys(FRAMES).indexOf(app.shown.frames) + 1) % 4] });
  else if (view) app.lookFrom(view);
  else if (event.key === "b" && app.ghost) app.show({ before: !app.shown.before });
  else if (event.key === "n" || event.key === "N") app.changesPanel.next(event.key === "n" ? 1 : -1);
  else if (event.key === "Escape" && app.card.from) app.card.measure("");
  else if (event.key === "Escape") app.select("");
  else if (event.key === "h" || event.key === "Home") app.lookFrom("iso");
  else if (event.key === "/") app.find();
  else return;
  event.preventDefault();
}
