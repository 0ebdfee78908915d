/** What is above the robot: a mistake of the description; and what it warns of, which is also listed beside the name. */

import { element } from "../dom.js";
import { place } from "./card.js";

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

function counted(count, one, many) {
  return count ? `${count} ${count === 1 ? one : many}` : "";
}

/** Return the meshes and images of a robot that are not shown, and why. */
function missing(table = {}) {
  return Object.entries(table).filter(([, entry]) => entry.missing).map(([name, entry]) => ({ text: `${name} is not shown: ${entry.missing}` }));
}

/** Return what there is to say of a page that was made without meshes, such as with --no-meshes. */
function withoutMeshes({ links, meshes }) {
  const isLeftOut = ({ kind, mesh }) => kind === "mesh" && !meshes[mesh];
  const some = links.some(({ visual, collision }) => [...visual, ...collision].some(isLeftOut));
  return some ? [{ text: "this page was made without meshes: parts that are drawn from mesh files are not shown" }] : [];
}

/** Return the link that a warning is about: the first one that it names, or else the one that is defined above its line. */
export function partOf(robot, text, where) {
  const names = new Map([...robot.joints.map(({ name, child }) => [name, child]), ...robot.sensors.map(({ name, frame }) => [name, frame]), ...robot.links.map(({ name }) => [name, name])]);
  const named = [...text.matchAll(/["'`]([^"'`\n]+)["'`]|([\w./-]+)/g)].map((found) => found[1] ?? found[2]).find((name) => names.has(name));
  if (named) return names.get(named);
  const above = robot.links.filter((link) => where && link.where?.file === where.file && link.where.line <= where.line);
  return above.sort((one, other) => other.where.line - one.where.line)[0]?.name ?? "";
}

/** Warnings, and meshes that are not shown: `list` folds them out beside the name, `root` is a line over the robot. */
export class Warnings {
  constructor(app) {
    this.app = app;
    this.said = "";
    this.count = element("summary", {});
    this.entries = element("ul", {});
    this.list = element("details", { class: "warnings", hidden: true });
    const unfold = () => {
      app.root.classList.remove("no-left");
      this.list.open = true;
    };
    this.line = element("button", { title: "which ones", onclick: unfold });
    this.close = element("button", { class: "close", "aria-label": "close", onclick: () => (this.root.hidden = true) }, "×");
    this.root = element("section", { class: "warned", hidden: true, role: "status" });
  }

  /** Show what there is of a robot; a line that was closed comes back with something else to say. */
  show(robot) {
    const { warnings = [], meshes, textures } = robot;
    const [lost, pale] = [missing(meshes), missing(textures)];
    const none = withoutMeshes(robot);
    const every = [...none, ...lost, ...pale, ...warnings];
    const said = JSON.stringify(every);
    if (said === this.said) return;
    this.said = said;
    const counts = [none.length ? "no meshes in this page" : "", counted(lost.length, "mesh is not shown", "meshes are not shown"), counted(pale.length, "image is not shown", "images are not shown"), counted(warnings.length, "warning", "warnings")];
    this.line.textContent = this.count.textContent = counts.filter(Boolean).join(", ");
    this.root.hidden = this.list.hidden = !every.length;
    this.root.replaceChildren(...(every.length ? [this.line, this.close] : []));
    this.list.replaceChildren(...(every.length ? [this.count, this.entries] : []));
    const item = ({ text, where }) => {
      const part = partOf(robot, text, where);
      const words = part ? element("button", { class: "go", title: `look at ${part}`, onclick: () => this.app.fly(part) }, text) : text;
      return element("li", {}, element("p", {}, words), place(where));
    };
    this.entries.replaceChildren(...every.map(item));
  }
}
