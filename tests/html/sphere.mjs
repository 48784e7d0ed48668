// sphere.mjs ASSETS JOB: the picture of a lit sphere as the script draws it. JOB is JSON: {model, parameters: {name: [by channel]},
// channels, size, light}, or with sphere, the data of a page, in the place of model and parameters; printed is JSON, 8 bits of red, green,
// blue and coverage for each pixel.
import {readFileSync} from "node:fs";
import vm from "node:vm";

const [, , assets, job] = process.argv;
const read = name => readFileSync(`${assets}/${name}`, "utf8");
const context = vm.createContext({Math, Float64Array, Uint8ClampedArray, Map, Number, console, atob});
vm.runInContext(`${read("model.js")}\n${read("chart.js")}\n${read("spheres.js").split("const Spheres =")[0]}\nglobalThis.found = {Model, Sphere};`, context);
const {Model, Sphere} = context.found;
const {model, parameters, sphere, channels, size, light} = JSON.parse(readFileSync(job, "utf8"));
function surface() {
    if (sphere) {
        const values = Sphere.decode(sphere);
        return (g, out) => Sphere.interpolate(sphere, values, g, out);
    }
    const compiled = Model.compile(model, (name, c) => parameters[name][Math.min(c || 0, parameters[name].length - 1)], channels);
    return (g, out) => compiled.all(g, out);
}
const picture = Sphere.render(surface(), channels, size, light, 4);
console.log(JSON.stringify([...Sphere.shown(picture, channels, 0)]));
