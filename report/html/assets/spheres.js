/* A lit sphere, as the program draws it: from far away, one distant light of irradiance pi, L = pi f cos(theta_i), pixels as means of
 * points on a lattice; and the three of the page, whose light is dragged. */
"use strict";
const Sphere = (() => {
    /* f(geometry, out [channels]); light a unit vector, x to the right, y up, the viewer at +z. [size size (channels + 1)]: radiance
     * times coverage, then coverage; points x points of a lattice in every pixel. */
    function render(f, channels, size, light, points) {
        const out = new Float64Array(size * size * (channels + 1)), one = new Float64Array(channels), step = 2 / (size * points), share = 1 / (points * points);
        for (let j = 0; j < size; j++)
            for (let i = 0; i < size; i++) {
                const at = (j * size + i) * (channels + 1);
                for (let q = 0; q < points * points; q++) {
                    const x = -1 + (i * points + q % points + 0.5) * step, y = 1 - (j * points + Math.floor(q / points) + 0.5) * step, z2 = 1 - x * x - y * y;
                    if (!(z2 > 0)) continue;
                    out[at + channels] += share;
                    const z = Math.sqrt(z2), s = Math.sqrt(x * x + z2), [lx, ly, lz] = light, wiz = x * lx + y * ly + z * lz;
                    if (!(wiz > 1e-8) || !(z > 1e-8)) continue;
                    /* tangent along the parallel, bitangent along the meridian */
                    const wix = (z * lx - x * lz) / s, wiy = (-y * x * lx + s * s * ly - y * z * lz) / s, wox = -x / s, woy = -y * z / s;
                    f(Model.geometry(wix, wiy, wiz, wox, woy, z), one);
                    for (let c = 0; c < channels; c++) out[at + c] += share * Math.PI * one[c] * wiz;
                }
            }
        return out;
    }

    const srgb = e => { const v = Math.min(Math.max(e, 0), 1); return v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055; };

    /* 8 bits [size size 4]: red, green, blue of the sphere itself, coverage as alpha. colours [9]: rows of red, green, blue of the three
     * channels; left out, they are these themselves. */
    function shown(picture, channels, exposure, colours) {
        const colour = (at, c) => channels !== 3 ? picture[at] : !colours ? picture[at + c] :
            colours[3 * c] * picture[at] + colours[3 * c + 1] * picture[at + 1] + colours[3 * c + 2] * picture[at + 2];
        const pixels = picture.length / (channels + 1), out = new Uint8ClampedArray(4 * pixels), gain = 2 ** exposure;
        for (let k = 0; k < pixels; k++) {
            const coverage = picture[k * (channels + 1) + channels];
            if (!(coverage > 0)) continue;
            for (let c = 0; c < 3; c++) out[4 * k + c] = Math.round(255 * srgb(Math.max(gain * colour(k * (channels + 1), c) / coverage, 0)));
            out[4 * k + 3] = Math.round(255 * coverage);
        }
        return out;
    }

    /* Of the mean over channels, by the diverging map: blue where b is below a. */
    function difference(a, b, channels, exposure, clip) {
        const pixels = a.length / (channels + 1), out = new Uint8ClampedArray(4 * pixels), gain = 2 ** exposure;
        for (let k = 0; k < pixels; k++) {
            const at = k * (channels + 1), coverage = a[at + channels];
            if (!(coverage > 0)) continue;
            let sum = 0;
            for (let c = 0; c < channels; c++) sum += (b[at + c] - a[at + c]) / channels / coverage;
            const colour = Chart.diverging(0.5 + 0.5 * gain * sum / clip).match(/\d+/g);
            for (let c = 0; c < 3; c++) out[4 * k + c] = Number(colour[c]);
            out[4 * k + 3] = Math.round(255 * coverage);
        }
        return out;
    }

    /* The numbers of page data, "sphere", [channels][nodes]: 16 bits each, a sign and a logarithm; 0x8000 for what is not known. */
    function decode(grid) {
        const sizes = Float64Array.from({length: 0x8000}, (_, m) => m === 0 ? 0 : Math.exp(-grid.span * (0x7fff - m) / 0x7ffe));
        return grid.values.map(({top, codes}) => {
            const bytes = atob(codes);
            return Float64Array.from({length: bytes.length / 2}, (_, k) => {
                const code = bytes.charCodeAt(2 * k) << 8 | bytes.charCodeAt(2 * k + 1);
                return code === 0x8000 ? NaN : (code & 0x8000 ? -top : top) * sizes[code & 0x7fff];
            });
        });
    }

    /* Linear between the nodes that there are. Over theta_h, theta_d and phi_d; or, of a
     * surface with a direction, over x and y of the half vector, theta_d and phi_d + phi_h. */
    function interpolate(grid, values, g, out) {
        out.fill(0);
        if (!g) return;
        const cos = Math.min((g.iz + g.oz) / (2 * g.c), 1), h = Math.acos(cos), sin = Math.sqrt(1 - cos * cos), d = Math.acos(Math.min(g.c, 1));
        /* phi_d: of wi about h, from the plane of h and the normal */
        const hx = -g.sx, hy = -g.sy, across = Math.hypot(hx, hy), ux = across > 1e-12 ? hx / across : 1, uy = across > 1e-12 ? hy / across : 0;
        const wx = g.tix * g.iz, wy = g.tiy * g.iz, px = (wx * ux + wy * uy) * cos - g.iz * sin, py = wy * ux - wx * uy;
        const nd = grid.theta_d, np = grid.phi_d, side = grid.side, nx = side || grid.theta_h, ny = side || 1, middle = (side - 1) / 2;
        const place = x => Math.min(middle * (1 + Math.sign(x) * Math.sqrt(Math.abs(x))), side - 1);
        let p = (Math.atan2(py, px) + (side ? Math.atan2(uy, ux) : 0)) / Math.PI;
        p -= Math.floor(p); /* half a turn */
        const ax = side ? place(ux * sin) : Math.min(Math.sqrt(h / (Math.PI / 2)) * nx, nx - 1), ay = side ? place(uy * sin) : 0;
        const ad = Math.min(d / (Math.PI / 2) * nd, nd - 1), ap = p * np, bx = Math.floor(ax), by = Math.floor(ay), bd = Math.floor(ad), bp = Math.floor(ap);
        const corners = side ? 16 : 8;
        let total = 0;
        for (let corner = 0; corner < corners; corner++) {
            const kx = corner & 1, kd = corner >> 1 & 1, kp = corner >> 2 & 1, ky = corner >> 3;
            const weight = (kx ? ax - bx : 1 - ax + bx) * (ky ? ay - by : 1 - ay + by) * (kd ? ad - bd : 1 - ad + bd) * (kp ? ap - bp : 1 - ap + bp);
            if (!(weight > 0) || bx + kx >= nx || by + ky >= ny || bd + kd >= nd) continue;
            const node = (((bx + kx) * ny + by + ky) * nd + bd + kd) * np + (bp + kp) % np;
            if (Number.isNaN(values[0][node])) continue;
            total += weight;
            for (let c = 0; c < values.length; c++) out[c] += weight * values[c][node];
        }
        for (let c = 0; c < values.length && total > 0; c++) out[c] /= total;
    }

    return {render, shown, difference, decode, interpolate};
})();

const Spheres = (() => {
    const SIZE = 96, CLIP = 0.25;
    /* What is drawn: data, each view by its name, a difference; of a comparison there are several differences to choose from. */
    let light = [-0.5, 0.5, Math.SQRT1_2], exposure = 0, flipped = false, canvases = {}, pending = 0, between = null, values = null;
    const views = () => Plots.state.views, captions = {};

    /* Channels of the page that make the colour, or the chosen one. */
    function channels() {
        const of = Plots.page.sphere.channels;
        return of.length === 3 ? of : [Plots.state.channel];
    }

    function modelPicture(view, points) {
        const k = channels();
        const f = (g, out) => { for (let c = 0; c < k.length; c++) out[c] = view.at(g, k[c]); };
        /* all at once where one fit has them all */
        const fit = Plots.fitOf(view.model, k[0]), together = k.every(n => Plots.fitOf(view.model, n) === fit), compiled = view.function_(k[0]), buffer = new Float64Array(Plots.result.fits[fit].channels.length);
        const all = (g, out) => { compiled.all(g, buffer); for (let c = 0; c < k.length; c++) out[c] = buffer[Plots.page.channels[k[c]].c]; };
        return Sphere.render(together ? all : f, k.length, SIZE, light, points);
    }
    function dataPicture(points) {
        const grid = Plots.page.sphere;
        if (!values || (grid.channels.length === 1 && grid.channels[0] !== Plots.state.channel)) return null;
        return Sphere.render((g, out) => Sphere.interpolate(grid, values, g, out), grid.values.length, SIZE, light, points);
    }

    /* How far the nodes' values are from the data, at the samples of the page: the median of |value / sample - 1|. */
    function offByNodes() {
        const {page, geometry, used} = Plots, grid = page.sphere, S = page.samples, one = new Float64Array(grid.values.length), off = [];
        for (let i = 0; i < S.even; i++) {
            if (!used(i) || !geometry[i]) continue;
            Sphere.interpolate(grid, values, geometry[i], one);
            grid.channels.forEach((k, c) => { if (S.values[k][i] > 0) off.push(Math.abs(one[c] / S.values[k][i] - 1)); });
        }
        return off.sort((a, b) => a - b)[Math.floor(off.length / 2)];
    }
    function sayNodes() {
        if (!values) return "The data are shown under the light above alone. ";
        const grid = Plots.page.sphere, off = offByNodes(), halves = grid.side ? `${grid.side} × ${grid.side} half vectors` : `${grid.theta_h} half angles`;
        return `The data are interpolated between nodes: ${halves}, ${grid.theta_d} difference angles, ${grid.phi_d} azimuths` + (off === undefined ? ". " : `; from the samples of the page these values are off by ${Page.number(100 * off, 2)} % (median). `);
    }

    function put(name, pixels) {
        const canvas = canvases[name];
        canvas.getContext("2d", {willReadFrequently: true}).putImageData(new ImageData(pixels, SIZE, SIZE), 0, 0);
    }
    function draw(points) {
        const n = channels().length, pictures = {data: dataPicture(points)}, of = views(), first = of[0].name, [a, b] = between;
        for (const view of of) pictures[view.name] = view.live ? modelPicture(view, points) : null;
        const empty = new Uint8ClampedArray(4 * SIZE * SIZE), shown = picture => picture ? Sphere.shown(picture, n, exposure, Plots.page.sphere.colours) : empty;
        captions.data.textContent = flipped ? `${first} (flipped)` : pictures.data ? "data" : "data: only under the light above";
        put("data", shown(pictures[flipped ? first : "data"]));
        for (const view of of) {
            captions[view.name].textContent = (of.length > 1 ? `${view.name}: ${view.expression.replace(/[/+]/g, "$&\u200b")}` : view.name) + (view.live ? "" : ", not evaluated on this page");
            put(view.name, shown(pictures[view.name]));
        }
        put("difference", pictures[a] && pictures[b] ? Sphere.difference(pictures[a], pictures[b], n, exposure, CLIP) : empty);
        captions.difference.textContent = `${b} less ${a}`;
    }
    /* Coarse while something moves, fine when it rests. */
    function redraw() {
        draw(1);
        clearTimeout(pending);
        pending = setTimeout(() => { draw(4); Page.byId("spheres").dataset.drawn = String(Number(Page.byId("spheres").dataset.drawn || 0) + 1); }, 120);
    }

    /* The light's highlight follows the pointer: on a mirror the normal there would be half way between light and view. */
    function aim(x, y) {
        const r = Math.min(Math.hypot(x, y), 0.995), s = Math.hypot(x, y) > 0 ? r / Math.hypot(x, y) : 0, n = [x * s, y * s, Math.sqrt(1 - r * r)];
        light = [2 * n[2] * n[0], 2 * n[2] * n[1], 2 * n[2] * n[2] - 1];
        redraw();
        sayLight();
    }
    function turn(dx, dy) {
        const half = [light[0], light[1], light[2] + 1], length = Math.hypot(...half);
        aim(half[0] / length + dx, half[1] / length + dy);
    }
    const lightSaid = Page.make("output", {id: "light"});
    function sayLight() {
        const theta = Math.acos(Math.min(Math.max(light[2], -1), 1)) * 180 / Math.PI, phi = Math.atan2(light[1], light[0]) * 180 / Math.PI;
        lightSaid.textContent = `light ${Page.number(theta, 3)}° from the view, ${Page.number(phi, 3)}° from the right`;
    }
    function flip() {
        flipped = !flipped;
        Page.byId("flip").setAttribute("aria-pressed", String(flipped));
        draw(4);
        Page.say(flipped ? `${views()[0].name} stands in the place of the data` : "the data stand in their place");
    }

    function canvasOf(name) {
        const canvas = Page.make("canvas", {width: SIZE, height: SIZE, tabindex: "0", role: "img", "aria-label": `${name}: a lit sphere. Drag, or use the arrow keys, to move the light; F flips data and ${views()[0].name}.`, id: `sphere-${name.toLowerCase()}`});
        const at = e => { const box = canvas.getBoundingClientRect(); aim(2 * (e.clientX - box.left) / box.width - 1, 1 - 2 * (e.clientY - box.top) / box.height); };
        canvas.addEventListener("pointerdown", e => { canvas.setPointerCapture(e.pointerId); at(e); });
        canvas.addEventListener("pointermove", e => { if (e.buttons & 1) at(e); });
        canvas.addEventListener("keydown", e => {
            const step = {ArrowLeft: [-0.05, 0], ArrowRight: [0.05, 0], ArrowUp: [0, 0.05], ArrowDown: [0, -0.05]}[e.key];
            if (step) { e.preventDefault(); turn(...step); }
        });
        canvases[name] = canvas;
        captions[name] = Page.make("figcaption", {}, name);
        return Page.make("figure", {}, canvas, captions[name]);
    }

    /* Which difference: of two models that between them, and of each to the data. */
    function differences() {
        const names = views().map(v => v.name), pairs = names.length > 1 ? [[names[0], names[1]], ["data", names[0]], ["data", names[1]]] : [["data", names[0]]];
        between = pairs[0];
        if (pairs.length === 1) return [];
        return [Page.make("label", {}, "difference ", Page.make("select", {id: "between", onchange: e => { between = pairs[e.target.selectedIndex]; draw(4); }}, ...pairs.map(([a, b]) => Page.make("option", {}, `${b} less ${a}`))))];
    }

    function begin() {
        const section = Page.byId("spheres");
        if (!section || !(views().some(v => v.live) || Plots.page.sphere.values)) return;
        values = Plots.page.sphere.values ? Sphere.decode(Plots.page.sphere) : null;
        const range = Page.make("input", {type: "range", id: "exposure", min: -8, max: 8, step: 0.5, value: 0, oninput: e => { exposure = Number(e.target.value); shownExposure.textContent = `${exposure} EV`; draw(1); redraw(); }}), shownExposure = Page.make("output", {for: "exposure"}, "0 EV");
        const names = views().map(v => v.name), button = Page.make("button", {type: "button", id: "flip", "aria-pressed": "false", onclick: flip}, `flip data and ${names[0]} (F)`);
        section.append(Page.make("div", {class: "spheres"}, ...["data", ...names, "difference"].map(canvasOf)),
            Page.make("div", {class: "controls"}, button, ...differences(), Page.make("label", {}, "exposure ", range, shownExposure), lightSaid),
            Page.make("p", {class: "note"}, "Light of irradiance π; values beyond 1 are cut off. " + sayNodes() + (names.length > 1 ? "Blue: what is named first is darker" : "Blue: the model is too dark") + `; the colours end at a difference of ${CLIP}.`));
        document.addEventListener("keydown", e => {
            if ((e.key === "f" || e.key === "F") && !e.ctrlKey && !e.metaKey && !e.altKey && !/^(INPUT|SELECT|TEXTAREA)$/.test(e.target.tagName)) flip();
        });
        Plots.onChange(what => { if (what === "parameters" || what === "channel" || what === "all") redraw(); });
        if (values && views().every(v => v.live)) Page.byId("sphere-pictures").hidden = true;
        sayLight();
        redraw();
    }

    return {begin};
})();
if (typeof module !== "undefined") module.exports = Sphere;
