/**
 * Build the page: all modules in one script, the styles, and the licences of what is in it, into `built/`.
 * The same sources give the same bytes.
 */

import { readFile, writeFile } from "node:fs/promises";
import { build } from "esbuild";

const OUT = new URL("built/", import.meta.url);

const { outputFiles, metafile } = await build({
  entryPoints: [new URL("src/main.js", import.meta.url).pathname],
  absWorkingDir: new URL(".", import.meta.url).pathname,
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "utf8",
  legalComments: "none",
  metafile: true,
  write: false,
});

/** Return the packages that are in the bundle. */
function packages() {
  const inside = Object.keys(metafile.inputs).map((file) => /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(file)?.[1]);
  return [...new Set(inside.filter(Boolean))].sort();
}

async function licences() {
  const texts = [];
  for (const name of packages()) {
    const folder = new URL(`node_modules/${name}/`, import.meta.url);
    const { version } = JSON.parse(await readFile(new URL("package.json", folder), "utf8"));
    texts.push(`${name} ${version}\n\n${(await readFile(new URL("LICENSE", folder), "utf8")).trim()}\n`);
  }
  return `What is in page.js beside the sources of rosorin-compile:\n\n${texts.join("\n")}`;
}

await writeFile(new URL("page.js", OUT), outputFiles[0].text);
await writeFile(new URL("page.css", OUT), await readFile(new URL("src/page.css", import.meta.url)));
await writeFile(new URL("LICENSES.txt", OUT), await licences());
