// drive.mjs KIND PAGE: a page in a browser, by pointer and by keyboard. KIND is fit, failed, in-plane, tabled, comparison or table. Every check
// that fails is printed; the status is 1 then, and 77 where browser or modules are not there.
import {createRequire} from "node:module";
import {existsSync, readFileSync} from "node:fs";

const require = createRequire(import.meta.url);
const [, , kind, path] = process.argv;
const BROWSERS = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
const executablePath = BROWSERS.find(b => b && existsSync(b));
let chromium, axe;
try {
    chromium = require("playwright-core").chromium;
    axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
} catch {
    console.log("skipped: the modules are not there (tests/html/install)");
    process.exit(77);
}
if (!executablePath) {
    console.log("skipped: chromium is not there (./setup renderers)");
    process.exit(77);
}

let failures = 0, checks = 0;
function check(good, what) {
    checks++;
    if (good) return;
    failures++;
    console.log(`failed: ${kind}: ${what}`);
}

/* ---- a page that is watched -------------------------------------------------------------------------------------------------------- */

const browser = await chromium.launch({executablePath, args: ["--no-sandbox"]});
async function open(options, script = true) {
    const context = await browser.newContext({viewport: {width: 1280, height: 900}, javaScriptEnabled: script, acceptDownloads: true, ...options});
    await context.addInitScript(() => { Object.defineProperty(navigator, "clipboard", {value: {writeText: async text => { window.copied = text; }}}); });
    const page = await context.newPage();
    page.setDefaultTimeout(15000);
    page.on("console", m => ["error", "warning"].includes(m.type()) && check(false, `console: ${m.text()}`));
    page.on("pageerror", e => check(false, `error: ${e.message}`));
    page.on("request", r => check(/^(file:|data:|blob:)/.test(r.url()) && (!r.url().startsWith("file:") || r.url().split("#")[0] === `file://${encodeURI(path)}`), `it asks for ${r.url().slice(0, 100)}`));
    const begin = Date.now();
    await page.goto(`file://${path}`);
    return {page, took: Date.now() - begin};
}

const text = (page, selector) => page.textContent(selector);
const pixels = (page, id) => page.evaluate(i => { const c = document.getElementById(i); return [...c.getContext("2d").getImageData(0, 0, c.width, c.height).data].reduce((s, v, k) => (s * 31 + v + k) % 1000003, 7); }, id);
const lines = page => page.evaluate(() => [...document.querySelectorAll("#slice .panels path.line")].map(p => p.getAttribute("d")).join("|"));
const lit = (page, figure) => page.locator(`#${figure} .panels circle.lit`).count();

async function audit(page, what) {
    await page.evaluate(axe);
    const found = await page.evaluate(() => window.axe.run(document, {resultTypes: ["violations"]}));
    for (const v of found.violations) check(false, `axe, ${what}: ${v.id}: ${v.help}: ${v.nodes.slice(0, 3).map(n => n.target.join(" ")).join("; ")}`);
    check(found.passes.length > 10, `axe, ${what}: only ${found.passes.length} rules passed`);
}

/* Every element that can have the focus is come to by Tab, in their order, and nothing holds it. */
async function tab(page) {
    const wanted = await page.evaluate(() => {
        const can = e => e.tabIndex >= 0 && !e.disabled && e.getClientRects().length && getComputedStyle(e).visibility === "visible";
        return [...document.querySelectorAll("a[href], button, input, select, [tabindex]")].filter(can).filter(e => e.type !== "radio" || e.checked).length;
    });
    await page.evaluate(() => { document.activeElement.blur(); window.scrollTo(0, 0); });
    const seen = new Set();
    for (let k = 0; k < wanted; k++) {
        await page.keyboard.press("Tab");
        seen.add(await page.evaluate(() => { const e = document.activeElement; e.dataset.tabbed = "1"; return [...document.querySelectorAll("*")].indexOf(e); }));
    }
    const must = {fit: ["sphere-model", "flip", "exposure", "back", "incidence", "logarithmic"], comparison: ["yardstick", "picks-b", "swap", "filter", "incidence", "sphere-a", "sphere-b", "between"]}[kind] || [];
    for (const id of must) check(await page.evaluate(i => document.getElementById(i).dataset.tabbed === "1", id), `Tab does not come to ${id}`);
    if (must.length) check(await page.locator("#image .panels svg[data-tabbed]").count() > 0, "Tab does not come to the image slices");
    check(seen.size >= wanted - 1, `by Tab ${seen.size} of ${wanted} places are come to`);
}

/* The browser itself holds back downloads that follow each other as fast as a script can click: then once more. */
async function saved(page, button) {
    for (let k = 0; k < 4; k++) {
        const began = page.waitForEvent("download", {timeout: 2000}).catch(() => null);
        await button.click();
        const download = await began;
        if (download) return {name: download.suggestedFilename(), text: readFileSync(await download.path(), "utf8")};
    }
    check(false, `nothing is saved by ${await button.getAttribute("aria-label")}`);
    return {name: "nothing", text: ""};
}

/* ---- what all pages do -------------------------------------------------------------------------------------------------------------- */

async function withoutScript() {
    const {page} = await open({}, false);
    const all = await text(page, "main");
    check(all.includes("SHA-256 of the input"), "without script: no digest of the input");
    if (kind !== "table") check(await page.locator("#verdict li").count() > 0, "without script: no verdict");
    check(await page.locator("figure .drawn svg:visible").count() >= (kind === "table" ? 2 : 4), "without script: figures");
    check(await page.locator("figure .drawn svg text").count() > 20, "without script: figures without text");
    await page.context().close();
}

async function links(page) {
    const broken = await page.evaluate(() => [...document.querySelectorAll("a[href^='#']")].map(a => a.getAttribute("href")).filter(h => !document.getElementById(h.slice(1))));
    check(broken.length === 0, `links to nowhere: ${broken}`);
    const first = page.locator("#verdict a").first();
    if (!await first.count()) return;
    await first.click();
    const target = await first.getAttribute("href");
    const top = await page.evaluate(h => document.querySelector(h).getBoundingClientRect().top, target);
    check(top > -5 && top < 900, `an alert does not lead to ${target}: it is at ${top}`);
}

async function saves(page) {
    for (const figure of await page.locator("figure:has(.saves)").all()) {
        const id = await figure.getAttribute("id");
        const [json, svg, csv] = [await saved(page, figure.getByRole("button", {name: "save JSON"})), await saved(page, figure.getByRole("button", {name: "save SVG"})), await saved(page, figure.getByRole("button", {name: "save CSV"}))];
        let series = 0;
        try { series = JSON.parse(json.text).panels.reduce((s, p) => s + p.series.length, 0); } catch (e) { check(false, `${json.name}: ${e.message}`); }
        check(series > 0, `${id}: no series in its JSON`);
        check(csv.text.split("\n").length > 3 && csv.text.startsWith("panel,series,kind,x,y"), `${id}: ${csv.text.slice(0, 60)}`);
        const parses = await page.evaluate(t => { const d = new DOMParser().parseFromString(t, "image/svg+xml"); return !d.querySelector("parsererror") && d.querySelectorAll("path, circle, rect, image").length > 3; }, svg.text);
        check(parses, `${id}: its SVG is none`);
    }
    const whole = await saved(page, page.getByRole("button", {name: "save all as JSON"}));
    check(JSON.parse(whole.text).schema.startsWith("facetfit."), "save all as JSON");
}

async function looks() {
    const {page} = await open({colorScheme: "dark"});
    const dark = await page.evaluate(() => getComputedStyle(document.body).backgroundColor.match(/\d+/g).slice(0, 3).reduce((s, v) => s + Number(v), 0));
    check(dark < 150, `dark: the paper is ${dark}`);
    await audit(page, "dark");
    await page.emulateMedia({media: "print", colorScheme: "light"});
    check(await page.locator(".saves:visible, .controls:visible").count() === 0, "print: buttons are printed");
    const paper = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    check(paper === "rgb(255, 255, 255)", `print: the paper is ${paper}`);
    const pdf = await page.pdf({format: "A4"});
    check(pdf.length > 20000, `print: ${pdf.length} bytes`);
    await page.context().close();
}

/* ---- of a fit ------------------------------------------------------------------------------------------------------------------------- */

async function sliders(page) {
    const range = page.locator("#slider-rows input[type=range]"), n = await range.count();
    check(n >= 2 && n <= 5, `${n} sliders`);
    const before = await text(page, "#change"), line = await lines(page);
    check(/times 1\./.test(before) || /times 1$/.test(before) || before.includes(": times 1."), `at the best: ${before}`);
    const whole = await page.evaluate(() => { const p = JSON.parse(document.getElementById("page").textContent); return p.samples.step === 1 && !p.channels_left_out && !p.robust; });
    if (whole) {
        const [best, fit] = [before.match(/at the best ([\d.e+-]*\d)/)[1], before.match(/all samples: ([\d.e+-]*\d)/)[1]].map(Number);
        check(Math.abs(best / fit - 1) < 1e-4, `the objective of the page is ${best}, that of the fit ${fit}`);
    }
    await range.first().focus();
    for (let k = 0; k < 60; k++) await page.keyboard.press("ArrowRight");
    const after = await text(page, "#change"), ratio = Number(after.match(/times ([\d.e+-]*\d)/)[1]);
    check(ratio > 1, `a parameter that moved: ${after}`);
    check(await lines(page) !== line, "the curve does not follow its parameter");
    await page.click("#back");
    check(await text(page, "#change") === before, "back to the best is not");
    check(await lines(page) === line, "back to the best: another curve");
}

async function incidences(page) {
    const range = page.locator("#incidence"), title = () => text(page, "#slice .panels svg text[font-weight=bold]");
    const before = await title();
    await range.focus();
    await page.keyboard.press("Home");
    check(Number(await range.getAttribute("max")) === 0 || await title() !== before, "another incidence: the same title");
    await page.keyboard.press("End");
    const linear = await lines(page);
    await page.click("#logarithmic");
    check(await lines(page) !== linear, "logarithmic or not: the same curve");
    if (await page.locator("#channel").count()) {
        const curve = await lines(page);
        await page.selectOption("#channel", {index: 0});
        check(await lines(page) !== curve, "another channel: the same curve");
    }
}

async function brush(page) {
    const cells = page.locator("#image .panels svg").first();
    const cell = cells.locator("rect[data-cell]").first();
    await cell.click();
    const n = await lit(page, "profile") + await lit(page, "coverage");
    check(n > 1, `brushed: ${n} samples are lit`);
    check(await page.locator("#image .panels rect.brush").count() >= 1, "brushed: no frame");
    await cells.focus();
    const said = await text(page, "#said");
    await page.keyboard.press("ArrowRight");
    check(await text(page, "#said") !== said, "the arrow keys do not move the brush");
    await page.keyboard.press("Escape");
    check(await lit(page, "coverage") === 0, "Escape does not lift the brush");
}

/* first: what F puts in the place of the data; last: the other view of a comparison, or the same. */
async function spheres(page, first, last) {
    if (!await page.locator(`#${first}`).count()) return false;
    const drawn = () => page.evaluate(() => Number(document.getElementById("spheres").dataset.drawn || 0));
    const rest = async before => { for (let k = 0; k < 200 && await drawn() <= before; k++) await page.waitForTimeout(50); };
    await rest(0);
    const before = await pixels(page, first), data = await pixels(page, "sphere-data");
    await page.locator("h1").click();
    await page.keyboard.press("f");
    check(await page.getAttribute("#flip", "aria-pressed") === "true", "F does not flip");
    check(await pixels(page, "sphere-data") === await pixels(page, first), "flipped: not the model");
    await page.keyboard.press("f");
    check(await pixels(page, "sphere-data") === data, "flipped back: other data");
    let n = await drawn();
    await page.locator(`#${first}`).scrollIntoViewIfNeeded();
    const box = await page.locator(`#${first}`).boundingBox(), other = await pixels(page, last);
    await page.mouse.move(box.x + 60, box.y + 60);
    await page.mouse.down();
    await rest(n);
    const pressed = await pixels(page, first);
    check(pressed !== before, "a light that was pressed elsewhere: the same picture");
    n = await drawn();
    await page.mouse.move(box.x + 130, box.y + 110, {steps: 4});
    await page.mouse.up();
    await rest(n);
    const dragged = await pixels(page, first);
    check(dragged !== pressed, "a light that was dragged: the same picture");
    check(await pixels(page, last) !== other, "a light that was dragged over one sphere: another stays as it was");
    n = await drawn();
    await page.locator(`#${first}`).focus();
    await page.keyboard.press("ArrowUp");
    await rest(n);
    check(await pixels(page, first) !== dragged, "the arrow keys do not move the light");
    return true;
}

/* ---- of a comparison --------------------------------------------------------------------------------------------------------------------- */

async function comparison(page) {
    const pair = await text(page, "#pair"), curve = await lines(page), image = await page.locator("#differ-image .panels svg").innerHTML();
    const drawn = () => page.evaluate(() => Number(document.getElementById("spheres").dataset.drawn || 0)), n = await drawn(), b = await pixels(page, "sphere-b");
    await page.locator("#matrix td[data-fit] button").last().click();
    check(await text(page, "#pair") !== pair, "a click on a cell chooses nothing");
    check(await lines(page) !== curve, "another model: the same curves");
    check(await page.locator("#differ-image .panels").innerHTML() !== image, "another model: the same difference");
    for (let k = 0; k < 200 && await drawn() <= n; k++) await page.waitForTimeout(50);
    check(await pixels(page, "sphere-b") !== b, "another model: the same sphere");
    check((await text(page, "#spheres figure:has(#sphere-b) figcaption")).startsWith("B: "), "the sphere of B does not say what it is of");
    const between = await pixels(page, "sphere-difference");
    await page.selectOption("#between", {label: "B less data"});
    check(await pixels(page, "sphere-difference") !== between, "another difference: the same picture");
    await page.selectOption("#between", {label: "B less A"});
    check(await pixels(page, "sphere-difference") === between, "the difference chosen again: another picture");
    const order = () => page.evaluate(() => [...document.querySelectorAll("#ranking-table tbody tr")].map(r => r.dataset.fit).join(","));
    const by = await order();
    let moved = false;
    for (const yardstick of ["log rmse", "BIC", "cube-root rmse", "rmse"]) {
        await page.selectOption("#yardstick", yardstick);
        moved ||= await order() !== by;
        const sorted = await page.evaluate(name => {
            const fits = JSON.parse(document.getElementById("result").textContent).fits, key = {"log rmse": f => f.residual.log_rmse, "BIC": f => f.bic, "cube-root rmse": f => f.residual.cube_root_rmse, "rmse": f => f.residual.rmse}[name];
            const v = [...document.querySelectorAll("#ranking-table tbody tr")].map(r => key(fits[r.dataset.fit]));
            return v.every((x, k) => k === 0 || v[k - 1] <= x);
        }, yardstick);
        check(sorted, `ranked by ${yardstick}: not in its order`);
    }
    check(moved, "no yardstick ranks otherwise");
    await page.selectOption("#yardstick", "objective");
    const names = () => page.evaluate(() => [...document.querySelectorAll("#ranking-table tbody tr")].filter(r => !r.hidden).map(r => r.textContent));
    await page.fill("#filter", "beckmann v-cavity");
    const filtered = await names();
    check(filtered.length > 0 && filtered.every(t => t.includes("beckmann") && t.includes("v-cavity")), `filtered: ${filtered.length} rows`);
    for (const [form, pattern] of [["LaTeX", /\\begin\{tabular\}[\s\S]*beckmann & v-cavity/], ["CSV", /^rank,distribution[\s\S]*,beckmann,v-cavity/], ["Markdown", /^\| rank \|[\s\S]*\| beckmann \| v-cavity/]]) {
        await page.getByRole("button", {name: `copy as ${form}`}).click();
        const copied = await page.evaluate(() => window.copied);
        check(pattern.test(copied), `copied as ${form}: ${String(copied).slice(0, 200)}`);
    }
    await page.fill("#filter", "");
    await page.getByRole("button", {name: "log rmse"}).click();
    check(await page.locator("#ranking-table th[aria-sort=ascending]").count() === 1, "a sorted column does not say so");
    await page.click("#swap");
}

/* ---- all ---------------------------------------------------------------------------------------------------------------------------------- */

const {page, took} = await open({});
console.log(`${kind}: loaded in ${took} ms`);
await audit(page, "light");
await links(page);
if (kind === "fit" || kind === "failed") {
    await sliders(page);
    await brush(page);
    check(await spheres(page, "sphere-model", "sphere-model"), "no spheres");
}
if (kind === "fit" || kind === "in-plane" || kind === "tabled") await incidences(page);
if (kind === "tabled") check(/does not evaluate/.test(await text(page, "#sliders")) && await page.locator("#sliders input").count() === 0, "a model that is a table has sliders, or does not say why not");
if (kind === "failed") check(/not converge/.test(await text(page, "#verdict")), "a fit that failed does not say so");
if (kind === "comparison") {
    check(await spheres(page, "sphere-a", "sphere-b"), "no spheres");
    await comparison(page);
}
await saves(page);
await tab(page);
await audit(page, "after all");
await page.context().close();
await withoutScript();
await looks();
await browser.close();
console.log(`${kind}: ${checks} checks, ${failures} failed`);
process.exit(failures ? 1 : 0);
