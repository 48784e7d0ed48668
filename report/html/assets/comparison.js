/* The page of a comparison: which two models are looked at, by which yardstick all are ranked, where the two differ. */
"use strict";
(() => {
    const {page, result, state, View, changed, RAD} = Plots;
    const table = Page.byId("ranking-table"), matrix = Page.byId("matrix");
    const chosen = {a: page.shown, b: page.rival}, COLOUR = {a: 1, b: 0};
    let picks = "b";

    /* ---- A and B ------------------------------------------------------------------------------------------------------------------- */

    const viewOf = which => new View(chosen[which] % Plots.perProblem, which.toUpperCase(), COLOUR[which]);
    const nameOf = fit => result.fits[fit].model;

    function mark() {
        for (const e of document.querySelectorAll("#ranking-table tr[data-fit], #matrix td[data-fit]")) {
            const fit = Number(e.dataset.fit);
            e.classList.toggle("a", fit === chosen.a);
            e.classList.toggle("b", fit === chosen.b);
        }
        said.textContent = `A: ${nameOf(chosen.a)}. B: ${nameOf(chosen.b)}.`;
    }
    function pick(fit, which) {
        chosen[which] = fit;
        state.views = [viewOf("a"), viewOf("b")];
        mark();
        changed("all");
        Page.say(`${which.toUpperCase()} is ${nameOf(fit)}`);
    }

    const said = Page.make("p", {id: "pair", "aria-live": "polite"});

    function addChoice() {
        const radio = which => Page.make("input", {type: "radio", name: "picks", id: `picks-${which}`, value: which, onchange: () => { picks = which; }});
        const [a, b] = ["a", "b"].map(radio);
        b.checked = true;
        const swap = Page.make("button", {type: "button", id: "swap", onclick: () => { [chosen.a, chosen.b] = [chosen.b, chosen.a]; pick(chosen.a, "a"); }}, "swap A and B");
        return Page.make("div", {class: "controls", role: "group", "aria-label": "What a click chooses"}, "a click on a model chooses", Page.make("label", {}, a, "A"), Page.make("label", {}, b, "B"), swap);
    }

    /* Cells and names become buttons. */
    function addPicks() {
        for (const cell of matrix.querySelectorAll("td[data-fit]")) {
            const fit = Number(cell.dataset.fit), button = Page.make("button", {type: "button", onclick: () => pick(fit, picks)}, cell.textContent);
            button.setAttribute("aria-label", `${nameOf(fit)}: ${cell.textContent}${cell.classList.contains("tied") ? ", not told apart from the best" : ""}`);
            cell.replaceChildren(button);
        }
        for (const row of table.tBodies[0].rows) {
            const fit = Number(row.dataset.fit), head = row.querySelector("th");
            head.replaceChildren(Page.make("button", {type: "button", onclick: () => pick(fit, picks)}, head.textContent));
        }
    }

    /* ---- the yardstick ---------------------------------------------------------------------------------------------------------------- */

    const yardsticks = {"objective": f => f.residual.objective, "rmse": f => f.residual.rmse, "cosine rmse": f => f.residual.cosine_rmse,
        "log rmse": f => f.residual.log_rmse, "cube-root rmse": f => f.residual.cube_root_rmse, "AIC": f => f.aic, "BIC": f => f.bic};
    const byDifference = name => name === "AIC" || name === "BIC";

    /* Over the least, from 0 to 9 at ten times it; of criteria by their difference, 9 at 100. */
    function shadeOf(name, value, least) {
        const t = byDifference(name) ? (value - least) / 100 : Math.log10(value / least);
        return Number.isFinite(t) ? Math.min(Math.max(Math.floor(t * 9), 0), 9) : 9;
    }

    function rank(name) {
        const value = fit => yardsticks[name](result.fits[fit]), rows = [...table.tBodies[0].rows], problem = row => Math.floor(Number(row.dataset.fit) / Plots.perProblem);
        rows.sort((x, y) => problem(x) - problem(y) || value(x.dataset.fit) - value(y.dataset.fit));
        const place = new Map();
        for (const row of rows) {
            const k = (place.get(problem(row)) || 0) + 1;
            place.set(problem(row), k);
            row.cells[0].dataset.value = k;
            row.cells[0].textContent = `${k} ${row.dataset.mark}`;
        }
        table.tBodies[0].append(...rows);
        for (const head of table.tHead.rows[0].cells) head.removeAttribute("aria-sort");
        const cells = [...matrix.querySelectorAll("td[data-fit]")], least = Math.min(...cells.map(c => value(c.dataset.fit)).filter(Number.isFinite));
        for (const cell of cells) {
            const v = value(cell.dataset.fit), text = byDifference(name) ? Page.number(v - least, 4) : Page.number(v / least, 4);
            cell.className = cell.className.replace(/shade\d/, `shade${shadeOf(name, v, least)}`);
            cell.firstElementChild.textContent = (cell.dataset.mark || "") + text;
            cell.firstElementChild.setAttribute("aria-label", `${nameOf(Number(cell.dataset.fit))}: ${text}${cell.classList.contains("tied") ? ", not told apart from the best by the objective" : ""}`);
        }
        matrix.caption.textContent = `${byDifference(name) ? `${name} less the least` : `${name} over the least`}, the best Fresnel and diffuse term of each by the objective; outlined: not told apart from the best by the objective`;
        Page.say(`ranked by ${name}`);
    }

    function addYardstick() {
        for (const row of table.tBodies[0].rows) row.dataset.mark = row.cells[0].textContent.replace(/[\d\s]/g, "");
        for (const cell of matrix.querySelectorAll("td[data-fit]")) cell.dataset.mark = cell.textContent.replace(/[^*~]/g, "");
        const select = Page.make("select", {id: "yardstick", onchange: e => rank(e.target.value)}, ...Object.keys(yardsticks).map(n => Page.make("option", {value: n}, n)));
        return Page.make("label", {}, "yardstick ", select);
    }

    function addTools() {
        const filter = Page.make("input", {type: "search", id: "filter", placeholder: "ggx v-cavity", oninput: e => Page.filter(table, e.target.value)});
        const tools = Page.make("div", {class: "controls"}, Page.make("label", {}, "rows with ", filter));
        Page.addCopies(table, tools);
        table.parentElement.before(tools);
        const section = Page.byId("ranking");
        section.querySelector("h2").after(Page.make("div", {class: "controls"}, addYardstick()), addChoice(), said);
        Page.sortable(table);
    }

    /* ---- where A and B differ --------------------------------------------------------------------------------------------------------- */

    const NX = 60, NY = 29;
    function drawDifference() {
        const [a, b] = state.views, k = state.channel;
        if (!a.live || !b.live) {
            const which = [a, b].filter(v => !v.live).map(v => `${v.name}, ${v.expression}`).join("; ");
            return {title: "difference", panels: [], nodes: [Page.make("p", {class: "note"}, `Not evaluated on this page: ${which}.`)]};
        }
        const z = [];
        let known = true, far = {value: 0};
        for (let n = 0; n < NX * NY; n++) {
            const ti = 3 * Math.floor(n / NX) + 1.5, to = 3 * (n % NX) - 88.5, g = Model.pair(ti * RAD, 0, to * RAD, Math.PI);
            const fa = a.at(g, k), fb = b.at(g, k), sd = Plots.sigmaOf(a.model, k, fa, g);
            if (!(sd > 0)) known = false;
            const value = (fb - fa) / (sd > 0 ? sd : fa);
            z.push(value);
            if (Math.abs(value) > Math.abs(far.value) && ti <= page.max_theta && Math.abs(to) <= page.max_theta) far = {value, ti, to};
        }
        const chart = {title: known ? "(B − A) / σ of one sample" : "(B − A) / A", x: {label: "θo, degrees", lo: -90, hi: 90}, y: {label: "θi, degrees", lo: 0, hi: 87}, nx: NX, ny: NY, z, clip: known ? 10 : 0.5, width: 640, height: 360};
        const where = far.value ? `Furthest apart within ${Page.number(page.max_theta, 3)}°: ${Page.number(far.value, 3)}${known ? " σ" : ""} at θi ${Page.number(far.ti, 3)}°, θo ${Page.number(far.to, 3)}°.` : "No difference.";
        return {title: "difference", panels: [{title: chart.title, series: [{kind: "image", name: "difference", nx: NX, ny: NY, z}]}], nodes: [Chart.cells(chart), Page.make("p", {class: "note"}, where)]};
    }

    /* ---- residuals by angle, a line for each masking ------------------------------------------------------------------------------------- */

    function bestOfMaskings() {
        const seen = new Map();
        for (const fit of result.ranking.slice(0, Plots.perProblem)) {
            const f = result.fits[fit];
            if (f.residual_bands && !seen.has(f.masking)) seen.set(f.masking, f);
        }
        return [...seen.entries()];
    }
    function drawResiduals() {
        const lines = bestOfMaskings(), labels = {theta_i: "θi", theta_h: "θh", theta_d: "θd"};
        const charts = Object.entries(labels).map(([place, label]) => {
            const empty = lines.length ? lines[0][1].residual_bands[place].filter(b => b.n === 0).map(b => ({kind: "grey", name: "", x: [b.from, b.to]})) : [];
            const series = lines.map(([masking, f], n) => {
                const bands = f.residual_bands[place].filter(b => b.n > 0 && b.mean !== null);
                return {kind: "line", name: `${masking} (${f.ndf})`, x: bands.map(b => (b.from + b.to) / 2), y: bands.map(b => 100 * b.mean), colour: n % 8, dash: Math.floor(n / 2) % 5};
            });
            return {title: "", x: {label: `${label}, degrees`, lo: 0, hi: 90, angle: true}, y: {label: "model − data, % of data"}, series: [...empty, {kind: "level", name: "", y: [0], x: []}, ...series], width: 380};
        });
        return {title: "residuals by angle", panels: Plots.panelsOf(charts), nodes: [...charts.map(Chart.plane), Page.make("p", {class: "note"}, "Grey: no samples. The best distribution under every masking.")]};
    }

    addTools();
    addPicks();
    mark();
    Plots.begin([viewOf("a"), viewOf("b")]);
    const difference = Plots.adopt("differ-image", drawDifference), residuals = Plots.adopt("residuals", drawResiduals);
    Plots.onChange(what => { if (what === "all" || what === "channel") difference(); });
    difference();
    residuals();
    Spheres.begin();
    Page.begin();
})();
