// Typesets LaTeX with MathJax: JSON {name: LaTeX} on the standard input becomes JSON {name: SVG} on the standard output.
// `make_equations.py` runs it in a folder where MathJax is installed.
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";

const require = createRequire(process.cwd() + "/");
const { mathjax } = require("mathjax-full/js/mathjax.js");
const { TeX } = require("mathjax-full/js/input/tex.js");
const { SVG } = require("mathjax-full/js/output/svg.js");
const { liteAdaptor } = require("mathjax-full/js/adaptors/liteAdaptor.js");
const { RegisterHTMLHandler } = require("mathjax-full/js/handlers/html.js");
require("mathjax-full/js/input/tex/ams/AmsConfiguration.js");

const adaptor = liteAdaptor();
RegisterHTMLHandler(adaptor);
const fail = (_, error) => {
  throw error;
};
const input = new TeX({ packages: ["base", "ams"], formatError: fail });
const page = mathjax.document("", { InputJax: input, OutputJax: new SVG({ fontCache: "none" }) });

const sources = JSON.parse(readFileSync(0, "utf8"));
const drawn = {};
for (const [name, tex] of Object.entries(sources)) {
  drawn[name] = adaptor.innerHTML(page.convert(tex, { display: true }));
}
process.stdout.write(JSON.stringify(drawn));
