/** The robots of a fleet: which numbers differ between them, each with its histogram, and which are likely wrong. */

import { element } from "../dom.js";

/** Return the histogram of a number: a bar for each step, beside them how many robots are far from the others. */
function histogram({ bins, below, above, low, high }) {
  const most = Math.max(...bins);
  const bars = bins.map((count) => element("i", { style: `height:${count ? Math.max(8, (100 * count) / most) : 0}%`, title: `${count} robots` }));
  const far = (count, where) => (count ? element("b", { class: "far", title: `${count} far ${where}` }, String(count)) : "");
  const said = `${bins.reduce((sum, count) => sum + count, 0)} robots from ${low} to ${high}`;
  return element("div", { class: "histogram", role: "img", "aria-label": said }, far(below, "below"), element("span", { class: "bars" }, ...bars), far(above, "above"));
}

/** Lists what differs in a fleet. */
export class Fleet {
  constructor(app) {
    this.app = app;
    this.root = element("section", { class: "changes fleet", hidden: true });
  }

  draw() {
    const { fleet } = this.app;
    this.root.hidden = !fleet;
    if (!fleet) return;
    const { said, numbers, problems, notes, lines } = fleet;
    const wrong = problems.map((one) => this.#line(one));
    this.root.replaceChildren(
      element("p", { class: "said" }, said),
      wrong.length ? element("details", { open: true }, element("summary", {}, `${wrong.length} to look at`), element("ul", {}, ...wrong)) : "",
      element("details", { open: true }, element("summary", {}, `${numbers.length} numbers differ`), element("ol", {}, ...numbers.map((one) => this.#number(one))), ...lines.map((line) => element("p", { class: "quiet" }, line))),
      notes.length ? element("details", {}, element("summary", { class: "quiet" }, `${notes.length} more to say`), element("ul", { class: "quiet" }, ...notes.map((one) => this.#line(one)))) : "",
    );
  }

  #line({ text, severity, more }) {
    return element("li", { class: severity }, element("p", {}, text), more ? element("small", {}, more) : "");
  }

  #number(one) {
    const { name, robots, smallest, median, largest, gives, frame } = one;
    const title = frame ? element("button", { class: "go", title: "look at it", onclick: () => this.app.fly(frame) }, name) : element("b", {}, name);
    const numbers = [["smallest", smallest], ["median", median], ["largest", largest]].map(([word, value]) => element("span", {}, element("small", {}, `${word} `), value));
    return element("li", {}, title, element("small", {}, ` ${robots} robots`), histogram(one), element("p", { class: "three" }, ...numbers), gives ? element("small", {}, `gives ${gives}`) : "");
  }
}
