// evaluate.mjs MODEL_JS JOBS: what the script of a page says of models. JOBS is JSON: [{model, parameters, directions}], directions
// [theta_i, phi_i, theta_o, phi_o] in degrees; printed is JSON, for each job the list of values, or null where the script has no formula.
import {createRequire} from "node:module";
import {readFileSync} from "node:fs";

const [, , script, jobs] = process.argv;
const Model = createRequire(import.meta.url)(script), RAD = Math.PI / 180;
console.log(JSON.stringify(JSON.parse(readFileSync(jobs, "utf8")).map(({model, parameters, directions}) => {
    if (!Model.offers(model)) return null;
    const compiled = Model.compile(model, name => parameters[name], 1);
    return directions.map(d => compiled.f(Model.pair(...d.map(x => x * RAD)), 0));
})));
