import js from "@eslint/js";
import globals from "globals";

export default [
  { ignores: ["built/"] },
  js.configs.recommended,
  { files: ["src/**"], languageOptions: { globals: globals.browser } },
  { files: ["*.js", "test/**"], languageOptions: { globals: globals.node } },
  { files: ["drive.js"], languageOptions: { globals: { ...globals.node, ...globals.browser } } },
  { rules: { eqeqeq: "error", "no-var": "error", "prefer-const": "error" } },
];
