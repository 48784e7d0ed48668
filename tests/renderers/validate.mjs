// node validate.mjs FILE...: are files what their formats ask for? By the extension: .gltf and .glb by Khronos' validator (no error, no
// warning), .mtlx by MaterialX (valid, and a shader can be made of every material), .usda by tinyusdz. A line for each; status 1 where one is not.
import fs from "fs";
import { createRequire } from "module";
import path from "path";
import { fileURLToPath, pathToFileURL } from "url";

const here = path.dirname(fileURLToPath(import.meta.url)), modules = path.join(here, "node_modules"), require = createRequire(import.meta.url);

async function gltf(file) {
    const report = await require("gltf-validator").validateBytes(new Uint8Array(fs.readFileSync(file)));
    const { numErrors, numWarnings } = report.issues;
    const said = report.issues.messages.map(m => `${m.code} ${m.pointer ?? ""}`).join("; ");
    return [numErrors + numWarnings === 0, `${numErrors} errors, ${numWarnings} warnings${said ? ": " + said : ""}`];
}

let loaded;
async function materialx() {
    if (loaded) return loaded;
    const bin = path.join(modules, "@needle-tools/materialx/bin");
    globalThis.fetch = undefined; // files, not addresses
    globalThis.require = require, globalThis.__dirname = bin; // what it takes for granted in node
    const { default: MaterialX } = await import(pathToFileURL(path.join(bin, "JsMaterialXGenShader.js")));
    const name = f => f.replace(/\.data$/, ".data.txt");
    const data = fs.readFileSync(path.join(bin, "JsMaterialXGenShader.data.txt"));
    const mx = await MaterialX({
        locateFile: f => path.join(bin, name(f)),
        wasmBinary: fs.readFileSync(path.join(bin, "JsMaterialXGenShader.wasm")),
        getPreloadedPackage: () => data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength),
    });
    const generator = mx.EsslShaderGenerator.create(), context = new mx.GenContext(generator);
    loaded = { mx, generator, context, library: mx.loadStandardLibraries(context) };
    return loaded;
}

async function mtlx(file) {
    const { mx, generator, context, library } = await materialx();
    const doc = mx.createDocument();
    doc.importLibrary(library);
    await mx.readFromXmlString(doc, fs.readFileSync(file, "utf8"), "");
    const message = {}, valid = doc.validate(message);
    const element = mx.findRenderableElement(doc);
    const shader = element ? generator.generate(element.getNamePath(), element, context) : null;
    const lines = shader ? shader.getSourceCode("pixel").split("\n").length : 0;
    return [valid && lines > 100, `${valid ? "valid" : JSON.stringify(message)}, MaterialX ${mx.getVersionString?.() ?? ""}, ${lines} lines of shader`];
}

async function usda(file) {
    const { default: init } = await import(pathToFileURL(path.join(modules, "tinyusdz/tinyusdz.js")));
    globalThis.fetch = undefined, globalThis.window = globalThis, process.type = "renderer"; // made for browsers alone
    const usd = await init({ wasmBinary: fs.readFileSync(path.join(modules, "tinyusdz/tinyusdz.wasm")) });
    const loader = new usd.TinyUSDZLoaderNative();
    const right = loader.loadFromBinary(fs.readFileSync(file), path.basename(file));
    return [right, right ? `${loader.numMaterials?.()} materials, ${loader.numMeshes?.()} meshes` : loader.error?.()];
}

const kinds = { ".gltf": gltf, ".glb": gltf, ".mtlx": mtlx, ".usda": usda };
let failures = 0;
for (const file of process.argv.slice(2)) {
    let right = false, said;
    try {
        [right, said] = await kinds[path.extname(file)](file);
    } catch (error) {
        said = String(error?.stack ?? error);
    }
    console.log(`${path.basename(file)}: ${right ? "right" : "WRONG"}, ${said}`);
    if (!right) failures++;
}
process.exit(failures ? 1 : 0);
