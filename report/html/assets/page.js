/* What all pages share: the numbers in them, messages, buttons that save, tables that are sorted, filtered and copied. */
"use strict";
const Page = (() => {
    const read = id => { const e = document.getElementById(id); return e ? JSON.parse(e.textContent) : null; };
    const byId = id => document.getElementById(id);

    function make(tag, attributes, ...children) {
        const e = document.createElement(tag);
        for (const [name, value] of Object.entries(attributes || {})) {
            if (name.startsWith("on")) e.addEventListener(name.slice(2), value);
            else if (value === true) e.setAttribute(name, "");
            else if (value !== false && value !== null && value !== undefined) e.setAttribute(name, value);
        }
        e.append(...children);
        return e;
    }

    /* Said to screen readers and shown at the end of the page. */
    function say(text) { byId("said").textContent = text; }

    /* Digits for people. */
    function number(x, digits) {
        if (x === null || x === undefined || !Number.isFinite(x)) return "";
        const text = x.toPrecision(digits || 4);
        return text.includes("e") ? Number(text).toString() : String(Number(text));
    }

    /* ---- saving and copying ---------------------------------------------------------------------------------------------------- */

    function save(name, type, text) {
        const url = URL.createObjectURL(new Blob([text], {type}));
        const link = make("a", {href: url, download: name});
        document.body.append(link);
        link.click();
        link.remove();
        setTimeout(() => URL.revokeObjectURL(url), 1000);
        say(`saved ${name}`);
    }

    async function copy(text, what) {
        try {
            await navigator.clipboard.writeText(text);
        } catch (error) { /* not allowed, or opened from disk in a browser that has no clipboard there */
            const area = make("textarea", {"aria-hidden": "true"});
            area.value = text;
            document.body.append(area);
            area.select();
            document.execCommand("copy");
            area.remove();
        }
        say(`copied ${what}`);
    }

    const csvCell = x => { const text = x === null || x === undefined || Number.isNaN(x) ? "" : String(x); return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text; };
    const csv = rows => rows.map(row => row.map(csvCell).join(",")).join("\n") + "\n";

    /* With the rules of the page for charts, and its colours in the place of their names: an SVG that is saved stands alone. */
    function svgText(svg) {
        const root = getComputedStyle(document.documentElement), rules = [...document.styleSheets[0].cssRules].filter(r => r.selectorText && r.selectorText.includes(".chart")).map(r => r.cssText).join("\n");
        const copied = svg.cloneNode(true), style = document.createElementNS("http://www.w3.org/2000/svg", "style");
        if (svg.classList.contains("chart")) { style.textContent = rules; copied.prepend(style); }
        return new XMLSerializer().serializeToString(copied).replace(/var\((--[\w-]+)\)/g, (_, name) => root.getPropertyValue(name).trim());
    }

    /* Several panels as one document. */
    function svgOf(figure) {
        const all = [...figure.querySelectorAll(".drawn > svg, .panels > svg")].filter(e => e.getClientRects().length);
        if (all.length === 1) return svgText(all[0]);
        let y = 0, width = 0, inside = "";
        for (const svg of all) {
            const box = svg.viewBox.baseVal;
            inside += svgText(svg).replace("<svg", `<svg y="${y}"`);
            y += box.height;
            width = Math.max(width, box.width);
        }
        return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${y}" viewBox="0 0 ${width} ${y}">${inside}</svg>`;
    }

    /* Buttons under a figure; data(): {title, panels: [{title, series: [{name, kind, x, y, ...}]}]}, what is drawn now. */
    function addSaves(figure, data) {
        const id = figure.id, rows = () => {
            const out = [["panel", "series", "kind", "x", "y", "low", "high", "z"]];
            (data().panels || []).forEach((panel, k) => panel.series.forEach(s => {
                if (s.z) s.z.forEach((z, i) => out.push([k + 1, s.name, s.kind, i % s.nx, Math.floor(i / s.nx), "", "", z]));
                else (s.x || []).forEach((x, i) => out.push([k + 1, s.name, s.kind, x, s.y ? s.y[i] : "", s.low ? s.low[i] : "", s.high ? s.high[i] : "", ""]));
            }));
            return csv(out);
        };
        const caption = figure.querySelector("figcaption");
        const saves = make("div", {class: "saves"},
            make("button", {type: "button", onclick: () => save(`${id}.json`, "application/json", JSON.stringify(data(), null, 1))}, "save JSON"),
            make("button", {type: "button", onclick: () => save(`${id}.svg`, "image/svg+xml", svgOf(figure))}, "save SVG"),
            make("button", {type: "button", onclick: () => save(`${id}.csv`, "text/csv", rows())}, "save CSV"));
        for (const b of saves.querySelectorAll("button")) b.setAttribute("aria-label", `${b.textContent}: ${caption ? caption.textContent : id}`);
        figure.append(saves);
    }

    /* Figures that the program drew, whose numbers lie beside them. */
    function addAllSaves() {
        for (const figure of document.querySelectorAll("figure.plot")) {
            const numbers = read(`${figure.id}-numbers`);
            if (numbers && !figure.querySelector(".saves")) addSaves(figure, () => numbers);
        }
    }

    /* ---- tables ---------------------------------------------------------------------------------------------------------------- */

    const cellText = cell => cell.textContent.trim();
    const cellValue = cell => cell.dataset.value !== undefined ? Number(cell.dataset.value) : cellText(cell) === "" ? NaN : Number(cellText(cell).replace(/[^\d.e+-]/g, ""));

    function sortable(table) {
        [...table.tHead.rows[0].cells].forEach((head, column) => {
            const button = make("button", {type: "button"}, head.textContent);
            head.replaceChildren(button);
            button.addEventListener("click", () => {
                const up = head.getAttribute("aria-sort") !== "ascending";
                for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
                head.setAttribute("aria-sort", up ? "ascending" : "descending");
                const rows = [...table.tBodies[0].rows], numeric = rows.some(r => r.cells[column].dataset.value !== undefined);
                rows.sort((a, b) => {
                    const x = a.cells[column], y = b.cells[column];
                    if (!numeric) return (up ? 1 : -1) * cellText(x).localeCompare(cellText(y));
                    const p = cellValue(x), q = cellValue(y);
                    if (Number.isNaN(p) || Number.isNaN(q)) return Number.isNaN(p) - Number.isNaN(q);
                    return (up ? 1 : -1) * (p - q);
                });
                table.tBodies[0].append(...rows);
                say(`sorted by ${button.textContent}, ${up ? "ascending" : "descending"}`);
            });
        });
    }

    /* Rows that hold all words. */
    function filter(table, words) {
        const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
        let shown = 0;
        for (const row of table.tBodies[0].rows) {
            const text = row.textContent.toLowerCase();
            row.hidden = !wanted.every(w => text.includes(w));
            shown += !row.hidden;
        }
        say(`${shown} of ${table.tBodies[0].rows.length} rows`);
    }

    const shownRows = table => [table.tHead.rows[0], ...[...table.tBodies[0].rows].filter(r => !r.hidden)].map(r => [...r.cells].map(cellText));
    const escapes = {"\\": "\\textbackslash{}", "~": "\\textasciitilde{}", "^": "\\textasciicircum{}", "&": "\\&", "%": "\\%", "$": "\\$", "#": "\\#", "_": "\\_", "{": "\\{", "}": "\\}"};
    const latexCell = text => text.replace(/[\\~^&%$#_{}]/g, c => escapes[c]).replace(/^(-?[\d.]+)e([+-]?\d+)$/, (_, a, b) => `$${a}\\times10^{${Number(b)}}$`);
    const forms = {
        "LaTeX": rows => `\\begin{tabular}{${"l".repeat(rows[0].length)}}\n\\hline\n` + rows.map((r, k) => r.map(latexCell).join(" & ") + " \\\\\n" + (k ? "" : "\\hline\n")).join("") + "\\hline\n\\end{tabular}\n",
        "CSV": csv,
        "Markdown": rows => rows.map((r, k) => `| ${r.map(c => c.replaceAll("|", "\\|")).join(" | ")} |\n` + (k ? "" : `|${"---|".repeat(r.length)}\n`)).join(""),
    };
    const tableText = (table, form) => forms[form](shownRows(table));

    function addCopies(table, where) {
        const caption = table.caption ? table.caption.textContent : "table";
        for (const form of Object.keys(forms)) {
            const button = make("button", {type: "button", onclick: () => copy(tableText(table, form), `the table as ${form}`)}, `copy as ${form}`);
            button.setAttribute("aria-label", `copy as ${form}: ${caption.slice(0, 60)}`);
            where.append(button);
        }
    }

    /* ---- what stands at the top ------------------------------------------------------------------------------------------------ */

    function addContents() {
        const list = make("ul", {});
        for (const heading of document.querySelectorAll("main > section > h2"))
            list.append(make("li", {}, make("a", {href: `#${heading.parentElement.id}`}, heading.textContent)));
        document.querySelector("header").append(make("nav", {"aria-label": "Contents"}, list));
    }

    function addDocument() {
        const result = byId("result") || byId("table");
        if (!result) return;
        const name = byId("result") ? "result.json" : "table.json";
        document.querySelector("header").append(make("div", {class: "saves"}, make("button", {type: "button",
            onclick: () => save(name, "application/json", JSON.stringify(JSON.parse(result.textContent), null, 1))}, "save all as JSON")));
    }

    function begin() {
        addContents();
        addDocument();
        addAllSaves();
    }

    return {read, byId, make, say, number, save, copy, csv, addSaves, sortable, filter, tableText, addCopies, begin};
})();
