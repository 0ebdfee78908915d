/** Following the files: the server tells when the robot is another one, or does not compile. */

/** Listen, and call back with what is new. Does nothing on a page that was opened from disk. */
export function follow({ onrobot, onproblem, onstate }) {
  const { protocol, pathname } = window.location;
  if (!protocol.startsWith("http") || document.body.dataset.live !== "yes") return null;
  const events = new EventSource("events");
  events.addEventListener("robot", async () => onrobot(await (await fetch("robot.json", { cache: "no-store" })).json()));
  events.addEventListener("problem", (event) => onproblem(JSON.parse(event.data)));
  events.onopen = () => onstate("live");
  events.onerror = () => onstate("the compiler has stopped");
  return { events, pathname };
}

/** Ask where the numbers of a frame come from, line by line; empty where nobody answers that. */
export async function explained(frame) {
  if (document.body.dataset.live !== "yes") return [];
  const answer = await fetch(`explain?frame=${encodeURIComponent(frame)}`);
  return answer.ok ? answer.json() : [];
}

/** Ask which links touch at a state; null where nobody answers that. */
export async function touching(state) {
  if (document.body.dataset.live !== "yes") return null;
  try {
    const answer = await fetch("touching", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(state) });
    return answer.ok ? await answer.json() : null;
  } catch {
    return null;
  }
}
