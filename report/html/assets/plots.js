/* The numbers of a page of fits, models over its samples, and the plots that fits and comparisons have in common.
 *
 * A view is a model with parameters that may be moved. Where the script has no formula for it, it is what the page has of it at the
 * samples (page data, "tabled"), and its parameters stay. */
"use strict";
const Plots = (() => {
    const page = Page.read("page"), result = Page.read("result");
    const S = page.samples, RAD = Math.PI / 180, count = S.theta_i.length;
    const perProblem = result.fits.length / page.problems;
    const geometry = S.theta_i.map((t, i) => Model.pair(t * RAD, S.phi_i[i] * RAD, S.theta_o[i] * RAD, S.phi_o[i] * RAD));
    const used = i => S.why[i] === 0;

    /* Half angle, difference angle, and the angle of the view in the plane of incidence, in degrees. */
    const theta_h = geometry.map(g => g ? Math.acos(Math.min((g.iz + g.oz) / (2 * g.c), 1)) / RAD : NaN);
    const theta_d = geometry.map(g => g ? Math.acos(Math.min(g.c, 1)) / RAD : NaN);
    const view_angle = S.theta_i.map((t, i) => {
        const phi = t > 1e-4 ? S.phi_i[i] : 0, along = Math.sin(S.theta_o[i] * RAD) * Math.cos((S.phi_o[i] - phi) * RAD);
        return Math.atan2(-along, Math.cos(S.theta_o[i] * RAD)) / RAD;
    });

    /* ---- what is chosen --------------------------------------------------------------------------------------------------------- */

    const state = {channel: Math.floor(page.channels.length / 2), slice: 0, log: null, cell: -1, lit: new Set(), views: []};
    const listeners = [];
    const onChange = f => listeners.push(f);
    function changed(what) { for (const f of listeners) f(what); }

    /* ---- views ------------------------------------------------------------------------------------------------------------------ */

    /* Which fit of a model has a channel of the page. */
    const fitOf = (model, k) => page.channels[k].problem * perProblem + model;

    class View {
        constructor(model, name, colour) {
            this.model = model;
            this.name = name;
            this.colour = colour;
            this.reset();
        }
        get expression() { return result.fits[this.model].model; }
        get live() { return page.models[this.model].live && Model.offers(page.models[this.model]); }
        /* Can it be drawn at all? */
        get shown() { return this.live || Boolean(page.models[this.model].tabled); }
        reset() {
            this.parameters = new Map();
            this.forget();
        }
        forget() {
            this.compiled = new Map();
            this.values = new Map();
        }
        /* Parameters of the fit that has channel k: name -> number, or numbers by channel. */
        parametersOf(k) {
            const fit = fitOf(this.model, k);
            if (!this.parameters.has(fit)) {
                const own = {};
                for (const [name, p] of Object.entries(result.fits[fit].parameters)) own[name] = Array.isArray(p.value) ? [...p.value] : p.value;
                this.parameters.set(fit, own);
            }
            return this.parameters.get(fit);
        }
        function_(k) {
            const fit = fitOf(this.model, k);
            if (!this.compiled.has(fit)) {
                const own = this.parametersOf(k);
                this.compiled.set(fit, Model.compile(page.models[fit], (name, c) => Array.isArray(own[name]) ? own[name][c || 0] : own[name], result.fits[fit].channels.length));
            }
            return this.compiled.get(fit);
        }
        /* f in channel k of the page. */
        at(g, k) { return this.function_(k).f(g, page.channels[k].c); }
        /* f at every sample; null where nothing is known. */
        atSamples(k) {
            if (!this.values.has(k)) {
                const tabled = page.models[fitOf(this.model, k)].tabled;
                this.values.set(k, this.live ? geometry.map(g => this.at(g, k)) : tabled ? tabled[k] : null);
            }
            return this.values.get(k);
        }
        set(k, name, value) {
            const own = this.parametersOf(k);
            if (Array.isArray(own[name])) own[name][page.channels[k].c] = value; else own[name] = value;
            const fit = result.fits[fitOf(this.model, k)].parameters;
            for (const [other, p] of Object.entries(fit)) if (p.tied && p.tied_to === name && !Array.isArray(own[other])) own[other] = own[name];
            this.forget();
        }
    }

    /* ---- the objective over the samples of the page ------------------------------------------------------------------------------ */

    const same = f => f;
    const transforms = {"cosine": same, "plain": same, "relative": same,
        "log": (f, x) => Math.log1p(f * x), "ln": f => f > 1e-30 ? Math.log(f) : -69.07755278982137 + f / 1e-30 - 1,
        "cube-root": (f, x) => f * x / Math.cbrt(f * x * f * x + 1e-16)};
    /* Half the sum of squares over the samples that are spread evenly, all channels of the page. */
    function objective(view) {
        const g = page.by_noise ? same : transforms[page.loss];
        let sum = 0, n = 0;
        for (let k = 0; k < page.channels.length; k++) {
            const f = view.atSamples(k), y = S.values[k], w = S.weights.length > 1 ? S.weights[k] : S.weights[0];
            if (!f || !g) return null;
            for (let i = 0; i < S.even; i++) {
                if (!used(i) || y[i] === null) continue;
                const x = geometry[i].iz, r = w[i] * (g(f[i], x) - g(y[i], x));
                sum += r * r;
                n += k === 0;
            }
        }
        return {value: sum / 2, samples: n};
    }

    /* Standard deviation of a value of channel k in direction g, by the file or by the noise that the fit has found; NaN: not known. */
    function sigmaOf(model, k, f, g) {
        const noise = result.fits[fitOf(model, k)].noise;
        if (!noise || !g) return NaN;
        const level = noise.levels.length > 1 ? noise.levels[page.channels[k].c] : noise.levels[0], x = Math.max(f, 0);
        return Math.sqrt((level.constant + level.linear * x + level.square * x * x) * g.iz ** noise.cos_i * g.oz ** noise.cos_o);
    }
    const sigmaAt = (model, k, i) => S.sigmas ? S.sigmas[k][i] : sigmaOf(model, k, S.values[k][i], geometry[i]);

    /* ---- figures ----------------------------------------------------------------------------------------------------------------- */

    /* Puts charts in the place of what the program drew, which stays for readers without script. draw(): {title, panels, nodes} */
    function adopt(id, draw) {
        const figure = Page.byId(id);
        if (!figure) return () => {};
        const drawn = figure.querySelector(".drawn"), panels = Page.make("div", {class: "panels"});
        drawn.hidden = true;
        drawn.after(panels);
        let last = {panels: []};
        Page.addSaves(figure, () => ({title: last.title, panels: last.panels}));
        return () => {
            const focused = panels.contains(document.activeElement) ? [...panels.children].indexOf(document.activeElement) : -1;
            last = draw();
            panels.replaceChildren(...last.nodes);
            if (focused >= 0 && panels.children[focused]) panels.children[focused].focus();
        };
    }
    const lit = i => state.lit.has(i);
    const channelName = k => page.channels.length > 1 ? `, ${page.channels[k].name}` : "";
    const cleanSeries = s => Object.fromEntries(Object.entries(s).filter(([, v]) => typeof v !== "function"));
    const panelsOf = charts => charts.map(c => ({title: c.title, series: c.series.map(cleanSeries)}));

    /* Values whose spread asks for a logarithmic axis. */
    function wantsLog(y) {
        const positive = y.filter(v => v > 0);
        return positive.length > 0 && Math.max(...positive) > 30 * Math.min(...positive);
    }

    /* ---- the plane of incidence -------------------------------------------------------------------------------------------------- */

    function curve(view, slice, k) {
        const x = [], y = [];
        if (view.live) {
            for (let d = -89.5; d <= 89.5; d += 0.5) {
                const g = Model.pair(slice.theta_i * RAD, slice.phi_i * RAD, d * RAD, slice.phi_i * RAD + Math.PI);
                x.push(d);
                y.push(view.at(g, k));
            }
            return {x, y};
        }
        const f = view.atSamples(k), order = [...Array(slice.n).keys()].map(i => slice.first + i).filter(i => geometry[i]).sort((a, b) => view_angle[a] - view_angle[b]);
        return {x: order.map(i => view_angle[i]), y: order.map(i => f ? f[i] : null)};
    }

    function partsOf(view, slice, k) {
        const f = view.function_(k), x = [], lobes = [], base = [];
        for (let d = -89.5; d <= 89.5; d += 0.5) {
            const p = f.parts(Model.pair(slice.theta_i * RAD, slice.phi_i * RAD, d * RAD, slice.phi_i * RAD + Math.PI), page.channels[k].c);
            x.push(d);
            lobes.push(p.lobes.reduce((a, b) => a + b, 0));
            base.push(p.base);
        }
        return [{kind: "line", name: "lobe", x, y: lobes, colour: 0, dash: 1}, {kind: "line", name: "diffuse", x, y: base, colour: 2, dash: 3}];
    }

    function drawSlice() {
        const slice = page.slices[state.slice], k = state.channel, index = [...Array(slice.n).keys()].map(i => slice.first + i).filter(i => S.values[k][i] !== null);
        const fitted = index.filter(used), others = index.filter(i => !used(i) && geometry[i]), y = fitted.map(i => S.values[k][i]);
        const log = state.log === null ? wantsLog(y) : state.log, box = Page.byId("logarithmic"), first = state.views[0];
        if (box) box.checked = log;
        const sd = fitted.map(i => first ? sigmaAt(first.model, k, i) : NaN);
        const series = [
            {kind: "points", name: "data", x: fitted.map(i => view_angle[i]), y, low: y.map((v, i) => v - sd[i]), high: y.map((v, i) => v + sd[i]), colour: 6, lit: j => lit(fitted[j])}];
        if (others.length) series.push({kind: "points", name: "not fitted", x: others.map(i => view_angle[i]), y: others.map(i => S.values[k][i]), colour: 7, lit: j => lit(others[j])});
        for (const view of state.views) if (view.shown) series.push({kind: "line", name: view.name, ...curve(view, slice, k), colour: view.colour, dash: view.colour === 1 ? 0 : 1});
        if (state.views.length === 1 && first.live && page.models[first.model].lobes.length && page.models[first.model].bases.length) series.push(...partsOf(first, slice, k));
        if (slice.theta_i > 0.01) series.push({kind: "rule", name: "mirror direction", x: [slice.theta_i]});
        const most = Math.max(...y.filter(Number.isFinite), 0), positive = y.filter(v => v > 0);
        const chart = {title: `θi = ${Page.number(slice.theta_i, 4)}°${page.isotropic ? "" : `, φi = ${Page.number(slice.phi_i, 4)}°`}${channelName(k)}`, width: 640, height: 340,
            x: {label: "θo, degrees", lo: -90, hi: 90, angle: true},
            y: {label: "f, 1/sr", log, lo: log ? (positive.length ? Math.max(Math.min(...positive), 1e-5 * most) / 1.3 : undefined) : 0, hi: most > 0 ? (log ? 2 : 1.15) * most : undefined}, series};
        return {title: "plane of incidence", panels: panelsOf([chart]), nodes: [Chart.plane(chart)]};
    }

    /* ---- by half angle ----------------------------------------------------------------------------------------------------------- */

    const shownSamples = () => [...Array(S.even).keys()].filter(used);
    const thinned = (list, most) => { const step = Math.ceil(list.length / most); return list.filter((i, k) => k % step === 0 || lit(i)); };

    function drawProfile() {
        const k = state.channel, all = shownSamples(), list = thinned(all, 1200), y = list.map(i => S.values[k][i]);
        const x = list.map(i => theta_h[i]), litAt = j => lit(list[j]);
        const series = [{kind: "points", name: "data", x, y, colour: 6, radius: 1.6, lit: litAt}];
        for (const view of state.views) {
            const f = view.atSamples(k);
            if (f) series.push({kind: "points", name: view.name, x, y: list.map(i => f[i]), colour: view.colour, radius: 1.1});
        }
        const axis = {label: "θh, degrees", lo: 0, hi: 90, angle: true}, charts = [{title: `BRDF by half angle${channelName(k)}`, x: axis, y: {label: "f, 1/sr", log: true}, series}];
        const view = state.views[0], F = view && view.live ? view.function_(k) : null;
        if (F && F.D) {
            const c = page.channels[k].c, implied = list.map((i, j) => {
                const p = F.parts(geometry[i], c), rest = p.base + p.lobes.slice(1).reduce((a, b) => a + b, 0);
                return p.lobes[0] > 1e-3 * (p.lobes[0] + rest) ? F.D(geometry[i]) * (y[j] - rest) / p.lobes[0] : NaN;
            });
            const tx = [], ty = [];
            for (let d = 0; d < 90; d += 0.5) { tx.push(d); ty.push(F.D(Model.pair(d * RAD, 0, d * RAD, 0))); }
            const most = Math.max(...ty), others = state.views.slice(1).filter(v => v.live && v.function_(k).D).map(v => ({kind: "line", name: v.name, x: tx, y: tx.map(d => v.function_(k).D(Model.pair(d * RAD, 0, d * RAD, 0))), colour: v.colour, dash: 1}));
            charts.push({title: "D: of the model, and as the data have it", x: axis, y: {label: "D, 1/sr", log: true, lo: Math.max(1e-6 * most, Math.min(...ty.filter(v => v > 0))), hi: 2 * most},
                series: [{kind: "points", name: "data", x, y: implied, colour: 6, radius: 1.6, lit: litAt}, {kind: "line", name: view.name, x: tx, y: ty, colour: view.colour}, ...others]});
            const factor = (title, label, of) => {
                const fy = tx.map(of);
                charts.push({title, x: {label, lo: 0, hi: 90, angle: true}, y: {label: title, lo: 0, hi: 1.04 * Math.max(1, ...fy)}, height: 240, series: [{kind: "line", name: view.name, x: tx, y: fy, colour: view.colour}]});
            };
            factor("Fresnel term", "θd, degrees", d => F.F(Model.pair(d * RAD, Math.PI, d * RAD, 0), c));
            factor("masking, light along the normal", "θo, degrees", d => F.G(Model.pair(0, 0, d * RAD, 0)));
        }
        return {title: "by half angle", panels: panelsOf(charts), nodes: charts.map(Chart.plane)};
    }

    /* ---- image slices, and the brush --------------------------------------------------------------------------------------------- */

    const CELLS = 18;
    const cellOf = i => Math.min(Math.floor(theta_h[i] / 90 * CELLS), CELLS - 1) * CELLS + Math.min(Math.floor(theta_d[i] / 90 * CELLS), CELLS - 1);
    const hasCell = i => Number.isFinite(theta_h[i]);

    function brush(cell) {
        state.cell = state.cell === cell ? -1 : cell;
        state.lit = new Set(state.cell < 0 ? [] : [...Array(count).keys()].filter(i => hasCell(i) && cellOf(i) === state.cell));
        Page.say(state.cell < 0 ? "brush lifted" : `brushed: θh ${Math.floor(state.cell / CELLS) * 90 / CELLS}° to ${(Math.floor(state.cell / CELLS) + 1) * 90 / CELLS}°, θd ${state.cell % CELLS * 90 / CELLS}° to ${(state.cell % CELLS + 1) * 90 / CELLS}°: ${state.lit.size} samples`);
        changed("brush");
    }
    function moveBrush(event) {
        const step = {ArrowLeft: -1, ArrowRight: 1, ArrowUp: CELLS, ArrowDown: -CELLS}[event.key];
        if (event.key === "Escape" && state.cell >= 0) brush(state.cell);
        if (step === undefined) return;
        event.preventDefault();
        const from = state.cell < 0 ? Math.floor(CELLS / 2) * CELLS : state.cell, to = state.cell < 0 ? from : from + step;
        if (to >= 0 && to < CELLS * CELLS) brush(to);
    }

    function cellMeans(values) {
        const sum = Array(CELLS * CELLS).fill(0), n = Array(CELLS * CELLS).fill(0);
        for (let i = 0; i < S.even; i++) {
            if (!used(i) || !hasCell(i) || values[i] === null || !Number.isFinite(values[i])) continue;
            sum[cellOf(i)] += values[i];
            n[cellOf(i)]++;
        }
        return sum.map((s, k) => n[k] ? s / n[k] : null);
    }

    function drawImages() {
        const k = state.channel, data = cellMeans(S.values[k]), charts = [], models = state.views.map(v => v.atSamples(k)).map(f => f ? cellMeans(f) : null);
        const positive = [...data, ...models.flatMap(m => m || [])].filter(v => v > 0), range = [Math.min(...positive), Math.max(...positive)];
        const base = {x: {label: "θd, degrees", lo: 0, hi: 90}, y: {label: "θh, degrees", lo: 0, hi: 90}, nx: CELLS, ny: CELLS, brushed: state.cell, onCell: brush};
        charts.push({...base, title: `data${channelName(k)}, 1/sr`, z: data, log: true, range});
        models.forEach((model, n) => {
            const name = state.views[n].name;
            if (!model) return;
            if (models.length === 1) charts.push({...base, title: `${name}, 1/sr`, z: model, log: true, range});
            charts.push({...base, title: `(${name} − data) / data`, z: data.map((d, c) => d > 0 && model[c] !== null ? (model[c] - d) / d : null), clip: 0.5});
        });
        const nodes = charts.map((c, n) => {
            const svg = Chart.cells({...c, label: `${c.title}: half angle against difference angle. Arrow keys move the brush, Escape lifts it.`});
            svg.setAttribute("tabindex", "0");
            svg.addEventListener("keydown", moveBrush);
            return svg;
        });
        return {title: "image slices", panels: charts.map(c => ({title: c.title, series: [{kind: "image", name: c.title, nx: CELLS, ny: CELLS, z: c.z}]})), nodes};
    }

    /* ---- coverage ---------------------------------------------------------------------------------------------------------------- */

    const WHY = ["used", "invalid in the file", "below the horizon", `beyond ${Page.number(page.max_theta, 4)}°`, "left out otherwise"], WHY_COLOUR = [0, 7, 3, 4, 1];

    function drawCoverage() {
        const view = {title: "view", series: []}, light = {title: "light", series: []}, table = [];
        WHY.forEach((name, why) => {
            const list = [...Array(count).keys()].filter(i => S.why[i] === why);
            if (!list.length) return;
            const turn = i => page.isotropic ? S.phi_i[i] : 0, litAt = j => lit(list[j]);
            light.series.push({name, colour: WHY_COLOUR[why], theta: list.map(i => S.theta_i[i]), phi: list.map(i => S.phi_i[i] - turn(i)), lit: litAt});
            view.series.push({name, colour: WHY_COLOUR[why], theta: list.map(i => S.theta_o[i]), phi: list.map(i => S.phi_o[i] - turn(i)), lit: litAt});
            table.push([name, list.length, WHY_COLOUR[why]]);
        });
        const legend = Page.make("ul", {class: "quiet"}, ...table.map(([name, n, c]) => Page.make("li", {style: `border-left:0.6rem solid var(--c${c});padding-left:0.4rem;list-style:none`}, `${name}: ${n} of the samples on this page`)));
        const panels = [light, view].map(p => ({title: p.title, series: p.series.map(s => ({kind: "points", name: s.name, x: s.phi, y: s.theta}))}));
        return {title: "coverage", panels, nodes: [Chart.disc(light), Chart.disc(view), legend]};
    }

    /* ---- all --------------------------------------------------------------------------------------------------------------------- */

    function addControls() {
        const figure = Page.byId("slice");
        if (!figure) return;
        const controls = Page.make("div", {class: "controls"}), slices = page.slices.length;
        const shownAngle = Page.make("output", {for: "incidence"}), say = () => { shownAngle.textContent = `${Page.number(page.slices[state.slice].theta_i, 4)}°`; };
        if (slices) {
            const range = Page.make("input", {type: "range", id: "incidence", min: 0, max: slices - 1, value: state.slice, oninput: e => { state.slice = Number(e.target.value); say(); changed("slice"); }});
            controls.append(Page.make("label", {}, "incidence ", range, shownAngle));
            say();
        }
        const log = Page.make("input", {type: "checkbox", id: "logarithmic", onchange: e => { state.log = e.target.checked; changed("slice"); }});
        controls.append(Page.make("label", {}, log, "logarithmic"));
        if (page.channels.length > 1) {
            const select = Page.make("select", {id: "channel", onchange: e => { state.channel = Number(e.target.value); changed("channel"); }}, ...page.channels.map((c, k) => Page.make("option", {value: k}, c.name)));
            select.value = state.channel;
            controls.append(Page.make("label", {}, "channel ", select));
        }
        figure.before(controls);
        const left = page.channels_left_out ? ` ${page.channels_left_out} more channels are not on this page.` : "";
        controls.after(Page.make("p", {class: "note"}, (S.step > 1 ? `Drawn of one of ${S.step} of ${S.of} samples; along the plane of incidence of up to 120 of each incidence.` : `Drawn of all ${S.of} samples.`) + left));
    }

    function begin(views) {
        state.views = views;
        state.slice = Math.min(Math.floor(page.slices.length / 2), Math.max(page.slices.length - 1, 0));
        addControls();
        const slice = page.slices.length ? adopt("slice", drawSlice) : () => {}, profile = adopt("profile", drawProfile), images = adopt("image", drawImages), coverage = adopt("coverage", drawCoverage);
        onChange(what => {
            slice();
            if (what === "slice") return;
            profile();
            images();
            if (what === "brush" || what === "all") coverage();
        });
        for (const view of views) if (!view.live) Page.byId("slices").append(Page.make("p", {class: "note"}, view.shown ? `${view.name}: ${view.expression} has integrals or tables that the script does not evaluate; its curves are what the program found at the samples.` : `${view.name}: ${view.expression} is not evaluated on this page.`));
        changed("all");
    }

    return {page, result, samples: S, geometry, state, View, fitOf, objective, sigmaOf, onChange, changed, begin, adopt, brush, panelsOf, used, RAD, perProblem};
})();
