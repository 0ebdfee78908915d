/**
 * A browser for tests, driven line by line: each line of standard input is a request as JSON, each line of standard
 * output its answer. The browser reaches this machine alone; what it asks for and what it complains of is kept.
 */

import { readFile } from "node:fs/promises";
import { createInterface } from "node:readline";
import puppeteer from "puppeteer-core";

const CELLS = [32, 20];
const PATIENCE = 170_000; // ms; a page takes seconds of computing, and machines are busy

const browser = await puppeteer.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  headless: true,
  userDataDir: process.env.PROFILE,
  args: [
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE localhost",
    "--disable-background-networking",
  ],
});

let page;
let lit = false;
let asked = [];
let complaints = [];

/**
 * Let a page draw nothing before it asks for its first frame. What it draws by then is the light of its room, which takes
 * some 5 s where no graphics card helps; without it a picture is darker, and all else is the same.
 */
function unlit() {
  let drawing = false;
  const ask = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (frame) => {
    drawing = true;
    return ask(frame);
  };
  for (const name of ["drawElements", "drawArrays"]) {
    const draw = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...given) {
      if (drawing) draw.apply(this, given);
    };
  }
}

/** Open an address in a page of its own, and wait until the robot is drawn, if `ready`; pictures need a `light`. */
async function open({ url, width = 1280, height = 800, touch = false, dark = false, ready = true, light = false, webgl = true }) {
  await page?.close();
  [asked, complaints, lit] = [[], [], light];
  page = await browser.newPage();
  if (!light) await page.evaluateOnNewDocument(unlit);
  if (!webgl) await page.evaluateOnNewDocument((() => {
    const get = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
      return kind.startsWith("webgl") ? null : get.call(this, kind, ...more);
    };
  }));
  page.setDefaultTimeout(PATIENCE);
  page.on("request", (request) => asked.push(request.url().slice(0, 200)));
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("console", (said) => ["error", "warn"].includes(said.type()) && complaints.push(said.text()));
  page.on("requestfailed", (request) => complaints.push(`${request.url().slice(0, 200)}: ${request.failure()?.errorText}`));
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }]);
  await page.setViewport({ width, height, isMobile: touch, hasTouch: touch });
  await page.goto(url, { waitUntil: "load" });
  if (ready) await page.waitForFunction("document.body.dataset.ready === 'yes'");
  await drawn();
  return {};
}

/** Wait until everything that has been asked for is on the screen. */
async function drawn() {
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done()))));
}

/** Return the mean colours of the cells of a picture, row by row: [red, green, blue] from 0 to 255. */
async function cells({ file }) {
  const data = `data:image/png;base64,${(await readFile(file)).toString("base64")}`;
  const blank = await browser.newPage();
  const found = await blank.evaluate(
    async (source, [wide, tall]) => {
      const picture = new Image();
      picture.src = source;
      await picture.decode();
      const canvas = new OffscreenCanvas(picture.width, picture.height);
      const context = canvas.getContext("2d");
      context.drawImage(picture, 0, 0);
      const mean = (column, row) => {
        const [x, y] = [Math.floor((column * picture.width) / wide), Math.floor((row * picture.height) / tall)];
        const [w, h] = [Math.floor(picture.width / wide), Math.floor(picture.height / tall)];
        const { data: bytes } = context.getImageData(x, y, w, h);
        const sum = [0, 0, 0];
        bytes.forEach((value, index) => index % 4 < 3 && (sum[index % 4] += value));
        return sum.map((value) => value / (w * h));
      };
      return Array.from({ length: wide * tall }, (_, index) => mean(index % wide, Math.floor(index / wide)));
    },
    data,
    CELLS,
  );
  await blank.close();
  return { found };
}

/** Return the pixel in the middle of an element, which is scrolled into view. */
async function middle(selector) {
  const found = await page.waitForSelector(selector);
  await found.scrollIntoView();
  await drawn(); // rows that come into sight get their height
  const { x, y, width, height } = await found.boundingBox();
  return [x + width / 2, y + height / 2];
}

const ANSWERS = {
  open,
  cells,
  evaluate: async ({ code }) => ({ found: (await page.evaluate(code)) ?? null }),
  wait: async ({ code }) => void (await page.waitForFunction(code)),
  click: async ({ at, on, count = 1 }) => void (await page.mouse.click(...(at ?? (await middle(on))), { count })),
  move: async ({ at }) => void (await page.mouse.move(...at)),
  size: async ({ width, height }) => void (await page.setViewport({ width, height })),
  drag: async ({ on, to }) => {
    await page.mouse.move(...(await middle(on)));
    await page.mouse.down();
    await page.mouse.move(...to, { steps: 4 });
    await page.mouse.up();
  },
  type: async ({ text }) => void (await page.keyboard.type(text)),
  press: async ({ key }) => void (await page.keyboard.press(key)),
  picture: async ({ file }) => {
    if (!lit) throw new Error("a page that was opened without light");
    await drawn();
    await page.waitForFunction("!window.app?.stage.coarse"); // all pixels are drawn again when nothing moves
    await page.screenshot({ path: file });
  },
  kept: async () => ({ found: { asked, complaints } }),
};

for await (const line of createInterface({ input: process.stdin })) {
  let answer;
  try {
    const request = JSON.parse(line);
    answer = (await ANSWERS[request.do](request)) ?? {};
  } catch (problem) {
    answer = { problem: String(problem.stack ?? problem) };
  }
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}
await browser.close();
