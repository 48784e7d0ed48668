/* The page of a fit: sliders that move parameters, where the fit started, the spheres. */
"use strict";
(() => {
    const {page, result, state, View, fitOf, objective, changed} = Plots;
    const SLIDERS = 5, STEPS = 1000;

    /* ---- parameters that are moved ------------------------------------------------------------------------------------------------ */

    const model = page.shown % Plots.perProblem, best = new View(model, "model", 1), moved = new View(model, "model", 1);
    const bestObjective = objective(best);

    /* Free ones: of the shape first, then of the channel. */
    function choose(k) {
        const parameters = result.fits[fitOf(model, k)].parameters, names = Object.keys(parameters).filter(n => !parameters[n].held && !parameters[n].tied);
        return [...names.filter(n => !Array.isArray(parameters[n].value)), ...names.filter(n => Array.isArray(parameters[n].value))].slice(0, SLIDERS);
    }

    /* A slider's place and the value there: scales go by their logarithm, what is not bounded by ten times the value. */
    function scaleOf(name, k) {
        const p = result.fits[fitOf(model, k)].parameters[name], c = page.channels[k].c, value = Array.isArray(p.value) ? p.value[c] : p.value;
        const offset = page.models[fitOf(model, k)].log[name], log = offset !== undefined;
        let [lo, hi] = p.bounds;
        if (log) {
            lo = Math.max(lo, (value + offset) / 20 - offset);
            hi = Math.min(hi, (value + offset) * 20 - offset);
            const a = Math.log(lo + offset), b = Math.log(hi + offset);
            return {value, to: x => (Math.log(x + offset) - a) / (b - a), from: t => Math.exp(a + t * (b - a)) - offset};
        }
        if (hi - lo > 100) { lo = Math.max(lo, value - 10 * Math.abs(value) - 1); hi = Math.min(hi, value + 10 * Math.abs(value) + 1); }
        return {value, to: x => (x - lo) / (hi - lo), from: t => lo + t * (hi - lo)};
    }

    const said = Page.make("p", {id: "change", "aria-live": "polite"}), rows = Page.make("div", {class: "controls", id: "slider-rows"});

    function sayChange() {
        const now = objective(moved), full = result.fits[page.shown].residual.objective;
        if (!now || !bestObjective) { said.textContent = "The objective of this loss is not computed on the page."; return; }
        const of = page.samples.step > 1 ? `one of ${page.samples.step} samples (${now.samples})` : `all ${now.samples} samples`;
        const left = page.channels_left_out ? `, ${page.channels.length} of ${page.channels.length + page.channels_left_out} channels` : "";
        said.textContent = `Objective over ${of}${left}: ${Page.number(now.value, 6)}, at the best ${Page.number(bestObjective.value, 6)}: times ${Page.number(now.value / bestObjective.value, 5)}. The fit's, over all samples: ${Page.number(full, 6)}.` + (page.robust ? " (Here without the robust loss.)" : "");
    }

    function addSlider(name, k) {
        const scale = scaleOf(name, k), id = `slider-${name.replace(/\W/g, "-")}`, out = Page.make("output", {for: id}), value = () => { const v = moved.parametersOf(k)[name]; return Array.isArray(v) ? v[page.channels[k].c] : v; };
        const input = Page.make("input", {type: "range", id, min: 0, max: STEPS, step: 1, "data-name": name});
        const show = () => { input.value = Math.round(scale.to(value()) * STEPS); out.textContent = Page.number(value(), 4); };
        input.addEventListener("input", () => {
            moved.set(k, name, scale.from(Number(input.value) / STEPS));
            out.textContent = Page.number(value(), 4);
            sayChange();
            changed("parameters");
        });
        show();
        rows.append(Page.make("label", {}, `${name}${Array.isArray(moved.parametersOf(k)[name]) && page.channels.length > 1 ? `[${page.channels[k].name}]` : ""} `, input, out));
    }

    function fillSliders() {
        rows.replaceChildren();
        for (const name of choose(state.channel)) addSlider(name, state.channel);
    }

    function addSliders() {
        const section = Page.make("section", {id: "sliders", "aria-labelledby": "sliders-heading"}, Page.make("h2", {id: "sliders-heading"}, "Other parameters"));
        Page.byId("slices").before(section);
        if (!moved.live) {
            section.append(Page.make("p", {class: "note"}, `The script does not evaluate ${moved.expression}, which has integrals or tables: its curves are those that the program found, and its parameters stay.`));
            return;
        }
        const back = Page.make("button", {type: "button", id: "back", onclick: () => { moved.reset(); fillSliders(); sayChange(); changed("parameters"); Page.say("back to the best"); }}, "back to the best");
        section.append(rows, Page.make("div", {class: "controls"}, back), said);
        fillSliders();
        sayChange();
        Plots.onChange(what => { if (what === "channel") fillSliders(); });
    }

    /* ---- where the fit started ----------------------------------------------------------------------------------------------------- */

    function fillStarts() {
        for (const row of document.querySelectorAll("table.parameters tbody tr")) {
            const start = page.start && page.start[row.dataset.name], cell = row.querySelector("td.start");
            if (start && cell) cell.textContent = Page.number(start.length > 1 ? start[Number(row.dataset.channel)] : start[0], 4);
        }
    }

    addSliders();
    fillStarts();
    Plots.begin([moved]);
    Spheres.begin();
    Page.begin();
})();
