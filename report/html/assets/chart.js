/* Charts as SVG: axes, lines, points, bands, cells, a hemisphere from above. They are redrawn as a whole; nothing is animated. */
"use strict";
const Chart = (() => {
    const NS = "http://www.w3.org/2000/svg";
    const WIDTH = 420, HEIGHT = 300, LEFT = 62, RIGHT = 12, TOP = 26, BOTTOM = 44;

    function element(tag, attributes, text) {
        const e = document.createElementNS(NS, tag);
        for (const [name, value] of Object.entries(attributes)) if (value !== undefined && value !== null) e.setAttribute(name, value);
        if (text !== undefined) e.textContent = text;
        return e;
    }
    const short = x => Math.round(x * 100) / 100;

    /* ---- axes ------------------------------------------------------------------------------------------------------------------ */

    function ticksOf(lo, hi, log) {
        const out = [];
        if (log) {
            const step = Math.max(1, Math.ceil((Math.log10(hi) - Math.log10(lo)) / 6));
            for (let k = Math.ceil(Math.log10(lo) - 1e-9); k <= Math.log10(hi) + 1e-9; k += step) out.push(10 ** k);
            if (out.length > 1) return out;
        }
        const raw = (hi - lo) / 5, power = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].map(f => f * power).find(s => s >= raw - 1e-12);
        for (let k = Math.ceil(lo / step - 1e-9); k * step <= hi + 1e-9 * step; k++) out.push(k * step);
        return out;
    }
    const degrees = (lo, hi) => { const step = hi - lo > 100 ? 30 : 15, out = []; for (let x = Math.ceil(lo / step) * step; x <= hi; x += step) out.push(x); return out; };

    /* Range of all finite values of the series along an axis, above 0 where it is logarithmic. */
    function rangeOf(series, keys, log) {
        let lo = Infinity, hi = -Infinity;
        for (const s of series) for (const key of keys) for (const v of s[key] || []) {
            if (v === null || !Number.isFinite(v) || (log && !(v > 0))) continue;
            lo = Math.min(lo, v);
            hi = Math.max(hi, v);
        }
        if (!(lo <= hi)) return log ? [0.1, 1] : [0, 1];
        if (lo === hi) return log ? [lo / 2, hi * 2] : [lo - Math.abs(lo) * 0.5 - 1e-9, hi + Math.abs(hi) * 0.5 + 1e-9];
        return [lo, hi];
    }

    function scaleOf(axis, series, keys, from, to) {
        let [lo, hi] = rangeOf(series, keys, axis.log);
        const pad = axis.log ? 1 : 0.04 * (hi - lo);
        if (!axis.log) { lo -= pad; hi += pad; } else { lo /= 1.15; hi *= 1.15; }
        if (axis.lo !== undefined) lo = axis.lo;
        if (axis.hi !== undefined) hi = axis.hi;
        if (!(hi > lo)) hi = lo + 1;
        const place = axis.log ? x => x > 0 ? (Math.log(x) - Math.log(lo)) / (Math.log(hi) - Math.log(lo)) : NaN : x => (x - lo) / (hi - lo);
        const at = x => x === null ? NaN : from + (to - from) * place(x);
        return {lo, hi, at, inside: x => { const p = place(x); return p >= -1e-9 && p <= 1 + 1e-9; }, ticks: axis.names ? [] : axis.angle ? degrees(lo, hi) : ticksOf(lo, hi, axis.log), log: axis.log};
    }

    const label = x => Math.abs(x) < 1e-12 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(0).replace("e+", "e") : String(Number(x.toPrecision(4)));

    function drawAxes(svg, chart, x, y, box) {
        for (const t of x.ticks) {
            svg.append(element("line", {class: "grid", x1: short(x.at(t)), x2: short(x.at(t)), y1: box.top, y2: box.bottom}));
            svg.append(element("text", {x: short(x.at(t)), y: box.bottom + 15, "text-anchor": "middle"}, label(t)));
        }
        for (const t of y.ticks) {
            svg.append(element("line", {class: "grid", x1: box.left, x2: box.right, y1: short(y.at(t)), y2: short(y.at(t))}));
            svg.append(element("text", {x: box.left - 6, y: short(y.at(t)) + 4, "text-anchor": "end"}, label(t)));
        }
        svg.append(element("rect", {class: "axis", x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top}));
        svg.append(element("text", {x: (box.left + box.right) / 2, y: box.bottom + 34, "text-anchor": "middle"}, chart.x.label));
        svg.append(element("text", {x: 14, y: (box.top + box.bottom) / 2, "text-anchor": "middle", transform: `rotate(-90 14 ${(box.top + box.bottom) / 2})`}, chart.y.label));
        svg.append(element("text", {x: box.left, y: 15, "font-weight": "bold"}, chart.title || ""));
    }

    /* ---- series ---------------------------------------------------------------------------------------------------------------- */

    const DASHES = ["", "7 3", "2 3", "7 3 2 3", "4 3"];
    const colour = s => `var(--c${(s.colour || 0) % 9})`;

    function pathOf(s, x, y) {
        let d = "", down = false;
        for (let i = 0; i < s.x.length; i++) {
            const px = x.at(s.x[i]), py = y.at(s.y[i]);
            if (!Number.isFinite(px) || !Number.isFinite(py)) { down = false; continue; }
            d += `${down ? "L" : "M"}${short(px)} ${short(py)}`;
            down = true;
        }
        return d;
    }

    function drawPoints(group, s, x, y) {
        const bars = s.low ? s.x.map((v, i) => Number.isFinite(x.at(v)) && Number.isFinite(y.at(s.low[i])) && Number.isFinite(y.at(s.high[i])) ? `M${short(x.at(v))} ${short(y.at(s.low[i]))}V${short(y.at(s.high[i]))}` : "").join("") : "";
        if (bars) group.append(element("path", {class: "error", d: bars, stroke: colour(s), fill: "none"}));
        for (let i = 0; i < s.x.length; i++) {
            const px = x.at(s.x[i]), py = y.at(s.y[i]);
            if (!Number.isFinite(px) || !Number.isFinite(py)) continue;
            const lit = s.lit && s.lit(i);
            group.append(element("circle", {cx: short(px), cy: short(py), r: lit ? 3.6 : s.radius || 2.2, fill: colour(s), class: lit ? "lit" : s.off && s.off(i) ? "off" : undefined}));
        }
    }

    function drawBand(group, s, x, y) {
        const up = s.x.map((v, i) => [x.at(v), y.at(s.high[i])]), down = s.x.map((v, i) => [x.at(v), y.at(s.low[i])]).reverse();
        const all = [...up, ...down].filter(p => p.every(Number.isFinite)).map(p => p.map(short).join(" "));
        if (all.length > 2) group.append(element("path", {class: "band", d: `M${all.join("L")}z`, fill: colour(s)}));
    }

    function drawSeries(group, s, x, y, box) {
        if (s.kind === "line") group.append(element("path", {class: "line", d: pathOf(s, x, y), stroke: colour(s), "stroke-dasharray": DASHES[s.dash || 0]}));
        else if (s.kind === "band") drawBand(group, s, x, y);
        else if (s.kind === "rule") group.append(element("line", {class: "axis", x1: short(x.at(s.x[0])), x2: short(x.at(s.x[0])), y1: box.top, y2: box.bottom, "stroke-dasharray": "3 3"}));
        else if (s.kind === "level") group.append(element("line", {class: "axis", x1: box.left, x2: box.right, y1: short(y.at(s.y[0])), y2: short(y.at(s.y[0]))}));
        else if (s.kind === "grey") group.append(element("rect", {class: "grey", x: short(x.at(s.x[0])), y: box.top, width: short(x.at(s.x[1]) - x.at(s.x[0])), height: box.bottom - box.top}));
        else drawPoints(group, s, x, y);
    }

    function drawLegend(svg, chart, box) {
        const named = chart.series.filter(s => s.name && s.kind !== "grey");
        let px = box.left, py = chart.height - 6;
        svg.setAttribute("viewBox", `0 0 ${chart.width} ${chart.height}`);
        const rows = [[]];
        for (const s of named) {
            const w = 36 + 6.8 * s.name.length;
            if (px + w > chart.width && rows[rows.length - 1].length) { rows.push([]); px = box.left; }
            rows[rows.length - 1].push([s, px]);
            px += w;
        }
        const extra = named.length ? 16 * rows.length : 0;
        svg.setAttribute("viewBox", `0 0 ${chart.width} ${chart.height + extra}`);
        svg.setAttribute("width", chart.width);
        svg.setAttribute("height", chart.height + extra);
        py = chart.height + 8;
        rows.forEach((row, k) => row.forEach(([s, at]) => {
            const y = py + 16 * k;
            if (s.kind === "line" || s.kind === "rule" || s.kind === "level") svg.append(element("line", {x1: at, x2: at + 18, y1: y - 4, y2: y - 4, stroke: s.kind === "line" ? colour(s) : "var(--quiet)", "stroke-width": 1.8, "stroke-dasharray": s.kind === "rule" ? "3 3" : DASHES[s.dash || 0]}));
            else if (s.kind === "band") svg.append(element("rect", {class: "band", x: at, y: y - 9, width: 18, height: 9, fill: colour(s)}));
            else svg.append(element("circle", {cx: at + 9, cy: y - 4, r: 2.6, fill: colour(s)}));
            svg.append(element("text", {x: at + 22, y}, s.name));
        }));
    }

    /* {title, x: {label, lo, hi, log, angle}, y: likewise, series: [{kind, name, x, y, low, high, colour, dash, lit(i), off(i)}], width, height} */
    function plane(chart) {
        chart.width = chart.width || WIDTH;
        chart.height = chart.height || HEIGHT;
        const box = {left: LEFT, right: chart.width - RIGHT, top: TOP, bottom: chart.height - BOTTOM};
        const svg = element("svg", {class: "chart", role: "img", "aria-label": chart.label || `${chart.title || ""} ${chart.y.label} against ${chart.x.label}`});
        const x = scaleOf(chart.x, chart.series, ["x"], box.left, box.right), y = scaleOf(chart.y, chart.series, ["y", "low", "high"], box.bottom, box.top);
        drawAxes(svg, chart, x, y, box);
        const clip = `clip-${plane.count++}`, group = element("g", {"clip-path": `url(#${clip})`}), clipPath = element("clipPath", {id: clip});
        clipPath.append(element("rect", {x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top}));
        svg.append(clipPath, group);
        for (const s of chart.series) drawSeries(group, s, x, y, box);
        drawLegend(svg, chart, box);
        return svg;
    }
    plane.count = 0;

    /* ---- colours of cells ------------------------------------------------------------------------------------------------------ */

    const VIRIDIS = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];
    const DIVERGING = [[33, 102, 172], [103, 169, 207], [209, 229, 240], [247, 247, 247], [253, 219, 199], [239, 138, 98], [178, 24, 43]];
    function mix(map, t) {
        const at = Math.min(Math.max(t, 0), 1) * (map.length - 1), k = Math.min(Math.floor(at), map.length - 2), f = at - k;
        return `rgb(${map[k].map((v, i) => Math.round(v + f * (map[k + 1][i] - v))).join(",")})`;
    }
    const sequential = t => mix(VIRIDIS, t), diverging = t => mix(DIVERGING, t);

    /* Cells: {title, x, y: {label, lo, hi}, nx, ny, z, log | clip, onCell(k), brushed, label, range}; z[row nx + column], rows upwards. */
    function cells(chart) {
        const width = chart.width || 300, height = chart.height || 300, bar = 58;
        const box = {left: LEFT, right: width - RIGHT - bar, top: TOP, bottom: height - BOTTOM};
        const svg = element("svg", {class: "chart", role: chart.onCell ? "group" : "img", "aria-label": chart.label || chart.title, viewBox: `0 0 ${width} ${height}`, width, height});
        const x = scaleOf({...chart.x, angle: true}, [], [], box.left, box.right), y = scaleOf({...chart.y, angle: true}, [], [], box.bottom, box.top);
        const known = chart.z.filter(v => v !== null && Number.isFinite(v) && (!chart.log || v > 0));
        const lo = chart.clip ? -chart.clip : chart.range ? chart.range[0] : Math.min(...known), hi = chart.clip || (chart.range ? chart.range[1] : Math.max(...known));
        const place = v => chart.log ? Math.log(v / lo) / Math.log(hi / lo) : (v - lo) / (hi - lo);
        const w = (box.right - box.left) / chart.nx, h = (box.bottom - box.top) / chart.ny;
        drawAxes(svg, chart, x, y, box);
        const group = element("g", {"shape-rendering": "crispEdges"});
        svg.append(group);
        chart.z.forEach((v, k) => {
            if (v === null || !Number.isFinite(v) || (chart.log && !(v > 0))) return;
            const rect = element("rect", {x: short(box.left + (k % chart.nx) * w), y: short(box.bottom - (Math.floor(k / chart.nx) + 1) * h), width: short(w + 0.3), height: short(h + 0.3), fill: (chart.clip ? diverging : sequential)(hi > lo ? place(v) : 0.5)});
            if (chart.onCell) { rect.dataset.cell = k; rect.style.cursor = "crosshair"; }
            group.append(rect);
        });
        if (chart.brushed >= 0) svg.append(element("rect", {class: "brush", x: short(box.left + (chart.brushed % chart.nx) * w), y: short(box.bottom - (Math.floor(chart.brushed / chart.nx) + 1) * h), width: short(w), height: short(h)}));
        for (let k = 0; k < 24; k++) svg.append(element("rect", {x: box.right + 10, y: short(box.bottom - (k + 1) * (box.bottom - box.top) / 24), width: 10, height: short((box.bottom - box.top) / 24 + 0.3), fill: (chart.clip ? diverging : sequential)((k + 0.5) / 24)}));
        [[lo, box.bottom], [hi, box.top + 10]].forEach(([v, at]) => Number.isFinite(v) && svg.append(element("text", {x: box.right + 23, y: at}, label(v))));
        if (chart.onCell) {
            const cellAt = e => { const c = e.target.dataset ? e.target.dataset.cell : undefined; return c === undefined ? null : Number(c); };
            svg.addEventListener("pointerdown", e => { const c = cellAt(e); if (c !== null) chart.onCell(c); });
        }
        return svg;
    }

    /* The hemisphere from above: points {theta, phi} in degrees. */
    function disc(chart) {
        const size = 300, r = 120, cx = size / 2, cy = size / 2 + 6;
        const svg = element("svg", {class: "chart", role: "img", "aria-label": chart.label || chart.title, viewBox: `0 0 ${size} ${size}`, width: size, height: size});
        for (const t of [30, 60, 90]) {
            svg.append(element("circle", {class: t === 90 ? "axis" : "grid", cx, cy, r: r * t / 90, fill: "none"}));
            svg.append(element("text", {x: cx + 3, y: short(cy - r * t / 90 + 12), "font-size": 10}, `${t}°`));
        }
        svg.append(element("text", {x: 4, y: 14, "font-weight": "bold"}, chart.title));
        for (const s of chart.series)
            for (let i = 0; i < s.theta.length; i++) {
                const lit = s.lit && s.lit(i), a = s.phi[i] * Math.PI / 180, d = r * s.theta[i] / 90;
                if (!(d <= 1.5 * r)) continue;
                svg.append(element("circle", {cx: short(cx + d * Math.cos(a)), cy: short(cy - d * Math.sin(a)), r: lit ? 3.6 : 1.6, fill: colour(s), class: lit ? "lit" : undefined}));
            }
        return svg;
    }

    return {plane, cells, disc, sequential, diverging, label};
})();
