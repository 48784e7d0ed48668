/* Reflectance models evaluated from their parameters, for the sliders and the lit spheres.
 *
 * A description names the terms and the parameters of a model (page data, "models"); Model.compile takes the numbers and gives a
 * function of the direction pair. Frame, slopes and symbols are those of the program: s slope of the half vector, S the stretch,
 *   q2 = (s - s0)^T S^-1 (s - s0),  v = t^T S t / (1 - t.s0)^2,  t = (w.x, w.y) / w.z,
 *   lobe = p(q2) / (ax ay sqrt(1 - r^2)) G K / (1 - to.s0),  K = 1 / (4 iz oz hz^4).
 * Lambda has no closed form here but for three distributions: Heitz 2014, section 3.4, by quadrature over the slope q,
 *   Lambda(a) = (2 / a) integral_a^inf p(q^2) q (sqrt(q^2 - a^2) - a acos(a / q)) dq. */
"use strict";
const Model = (() => {
    const COS_MIN = 1e-8, DEN_MIN = 1e-8, STEEPEST = 2 ** 34;
    const fifth = x => x * x * x * x * x;
    const clamp = (x, lo, hi) => x < lo ? lo : x > hi ? hi : x;
    const meanExp = x => x === 0 ? 1 : Math.expm1(x) / x;
    const positive = x => x > 0 ? x : 0;

    /* Gauss-Legendre on [-1, 1], 8 points. */
    const GAUSS_X = [0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363];
    const GAUSS_W = [0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763];
    function integral(f, lo, hi) {
        const middle = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
        let sum = 0;
        for (let k = 0; k < 4; k++) sum += GAUSS_W[k] * (f(middle - half * GAUSS_X[k]) + f(middle + half * GAUSS_X[k]));
        return half * sum;
    }
    function integralOver(f, lo, hi, panels) {
        let sum = 0;
        for (let k = 0; k < panels; k++) sum += integral(f, lo + (hi - lo) * k / panels, lo + (hi - lo) * (k + 1) / panels);
        return sum;
    }

    /* ---- distributions: own parameters -> {profile(q2), lambda(v) or none, tail}, and what `alpha` is to coupled terms -------- */

    const one = 1 / Math.PI;
    const ggxLambda = v => 0.5 * v / (1 + Math.sqrt(1 + v));
    function walterLambda(v) {
        const a = 1 / Math.sqrt(v);
        return a < 1.6 ? (1 - (1.259 - 0.396 * a) * a) / ((3.535 + 2.181 * a) * a) : 0;
    }
    const gaussianSlopes = q2 => Math.exp(-q2) * one;
    const studentT = nu => ({profile: q2 => one * Math.exp(-(nu + 1) * Math.log1p(q2 / nu)), powerTail: true});
    const cosines = q2 => 1 / Math.sqrt(1 + q2);
    const oneMinus = q2 => { const mz = cosines(q2); return q2 * mz * mz / (1 + mz); };

    const stretched = {
        "ggx": () => ({profile: q2 => one / ((1 + q2) * (1 + q2)), lambda: ggxLambda}),
        "beckmann": () => ({profile: gaussianSlopes}),
        "beckmann-walter": () => ({profile: gaussianSlopes, lambda: walterLambda}),
        "student-t": own => studentT(own[0] - 1),
    };
    /* Those that are not: p -> the same, with a width of its own where it has one. */
    const widths = {
        "phong": p => ({...studentT(p[0] / 2 + 1), alpha: Math.sqrt(2 / (p[0] + 2)), stretch: true}),
        "phong-walter": p => ({...studentT(p[0] / 2 + 1), lambda: walterLambda, alpha: Math.sqrt(2 / (p[0] + 2)), stretch: true}),
        "vmf": p => {
            const c = 1 / (2 * Math.PI * meanExp(-p[0]));
            return {profile: q2 => c * cosines(q2) ** 3 * Math.exp(-p[0] * oneMinus(q2))};
        },
        "gaussian": p => {
            const end = Math.min(Math.PI / 2, 6.5 * p[0]);
            const area = integralOver(x => Math.exp(-((x / p[0]) ** 2)) * Math.sin(2 * x), 0, end, 12);
            const c = 1 / (Math.PI * area);
            return {profile: q2 => { const t = Math.atan(Math.sqrt(q2)) / p[0]; return c / ((1 + q2) * (1 + q2)) * Math.exp(-t * t); }, alpha: p[0]};
        },
        "sgd": p => {
            const [alpha, power] = p;
            const total = integralOver(y => Math.exp(alpha - Math.exp(y) + (1 - power) * y), Math.log(alpha), Math.log(alpha + 45), 40);
            const c = Math.exp(alpha) / (Math.PI * alpha * total);
            return {profile: q2 => { const x = alpha + q2 / alpha; return c * Math.exp(-x - power * Math.log(x)); }};
        },
        "abc": p => {
            const [B, C] = p, logB = Math.log1p(B);
            const both = (1 + B) * logB * meanExp((1 - C) * logB) - logB * meanExp((2 - C) * logB), c = B * B / (2 * Math.PI * both);
            return {profile: q2 => c / ((1 + q2) * (1 + q2)) * Math.exp(-C * Math.log1p(B * oneMinus(q2)))};
        },
        "gtr": p => {
            const [alpha, gamma] = p, a2 = alpha * alpha, L = 2 * Math.log(alpha);
            const c = meanExp(L) / meanExp(-(gamma - 1) * L) * one;
            return {profile: q2 => c / ((1 + q2) * (1 + q2)) * Math.exp(gamma * Math.log1p((1 - a2) / (q2 + a2))), alpha};
        },
        "kelemen-ward": p => {
            const inv = 1 / (p[0] * p[0]), c = inv * one;
            return {profile: q2 => c * cosines(q2) * Math.exp(-q2 * inv), alpha: p[0]};
        },
        "kelemen-phong": p => {
            const half = 0.5 * p[0] + 2, c = (p[0] + 1) / (2 * Math.PI);
            return {profile: q2 => c * Math.exp(-half * Math.log1p(q2))};
        },
    };

    /* ---- Lambda by quadrature ------------------------------------------------------------------------------------------------- */

    function lambdaAt(ndf, a) {
        const inner = q => ndf.profile(q * q) * q * q * (Math.sqrt((q - a) * (q + a)) - a * Math.acos(a / q));
        const end = Math.log(STEEPEST / a);
        let sum = integralOver(z => 2 * z * inner(a * Math.exp(z * z)), 0, 0.5, 2) + integralOver(z => 2 * z * inner(a * Math.exp(z * z)), 0.5, 1, 2);
        for (let y = 1; y < end; y += 0.5) {
            const part = integral(x => inner(a * Math.exp(x)), y, Math.min(y + 0.5, end));
            sum += part;
            if (part < 1e-17 * sum && y > 3) break;
        }
        if (ndf.powerTail) { /* p = c q^-2k from here on */
            const Q = STEEPEST, p = ndf.profile(Q * Q), k = 0.5 * Math.log(p / ndf.profile(4 * Q * Q)) / Math.LN2;
            if (p > 0 && k > 1.5) sum += p * Q * Q * Q / (2 * k - 3);
        }
        return 2 / a * sum;
    }
    /* ln Lambda at steps of ln a, and between by the polynomial through six of them. */
    function tabled(ndf) {
        const step = 0.08, first = Math.log(1e-6), table = [];
        for (let k = 0; k < 400; k++) {
            const value = lambdaAt(ndf, Math.exp(first + k * step));
            if (!(value > 1e-13)) break;
            table.push(Math.log(value));
        }
        const last = first + (table.length - 1) * step;
        return v => {
            const x = -0.5 * Math.log(v);
            if (x > last) return 0;
            if (x < first) return Math.exp(table[0] + first - x); /* as 1 / a */
            const at = (x - first) / step, base = clamp(Math.floor(at) - 2, 0, Math.max(table.length - 6, 0)), n = Math.min(6, table.length);
            let sum = 0;
            for (let i = 0; i < n; i++) {
                let weight = 1;
                for (let j = 0; j < n; j++) if (j !== i) weight *= (at - base - j) / (i - j);
                sum += weight * table[base + i];
            }
            return Math.exp(sum);
        };
    }

    /* ---- maskings: G of both Lambdas and the geometry g ------------------------------------------------------------------------ */

    const apart = (w, phi) => w * phi / (w * phi + 1);
    const clearcoat = z => 2 * z / (z + Math.sqrt(1 / 16 + 15 / 16 * z * z)); /* of ggx, alpha = 1/4 */
    const maskings = {
        "smith-masking-only": {smith: true, G: (li, lo) => 1 / (1 + lo)},
        "smith-separable": {smith: true, G: (li, lo) => 1 / ((1 + li) * (1 + lo))},
        "smith-height-correlated": {smith: true, G: (li, lo) => 1 / (1 + li + lo)},
        "smith-direction-correlated": {smith: true, G: (li, lo, g) => {
            const k = apart(4.41, g.phi), gi = 1 / (1 + li), go = 1 / (1 + lo);
            return Math.min(gi, go) * (k * Math.max(gi, go) + 1 - k);
        }},
        "smith-height-direction-correlated": {smith: true, G: (li, lo, g, x) => {
            const k = apart(x, g.phi);
            return 1 / (1 + Math.max(li, lo) + k * Math.min(li, lo));
        }},
        "v-cavity": {G: (li, lo, g) => Math.min(1, (g.iz + g.oz) * Math.min(g.iz, g.oz) / (g.c * g.c))},
        "kelemen": {G: (li, lo, g) => g.iz * g.oz / (g.c * g.c)},
        "hammon": {alpha: true, G: (li, lo, g, x) => {
            const product = 2 * g.iz * g.oz;
            return product / (product + x * (g.iz + g.oz - product));
        }},
        "schlick-smith": {alpha: true, G: (li, lo, g, x) => {
            const k = 0.5 * x;
            return g.iz * g.oz / ((g.iz + k * (1 - g.iz)) * (g.oz + k * (1 - g.oz)));
        }},
        "disney-clearcoat": {G: (li, lo, g) => clearcoat(g.iz) * clearcoat(g.oz)},
        "none": {G: () => 1},
    };

    /* ---- Fresnel terms of c = wi.h --------------------------------------------------------------------------------------------- */

    const schlick = (f0, c) => { const m5 = fifth(1 - c); return m5 + (1 - m5) * f0; };
    function conductor(eta, k, c) {
        const x = (eta - 1) * (eta + 1) - k * k + c * c, y = 2 * eta * k, length = Math.hypot(x, y);
        const large = Math.sqrt(Math.max(0.5 * (length + Math.abs(x)), 1e-60)), small = 0.5 * y / large;
        const re = x < 0 ? small : large, im = x < 0 ? large : small;
        const of = (qr, qi) => ((qr - re) ** 2 + (qi - im) ** 2) / Math.max((qr + re) ** 2 + (qi + im) ** 2, 1e-60);
        return 0.5 * (of(c, 0) + of((eta - k) * (eta + k) * c, y * c));
    }
    const fresnels = {
        "schlick": (p, c) => schlick(p[0], c),
        "schlick-f82": (p, c) => {
            const cb = 1 / 7, dip = c * (1 - c) * fifth(1 - c) / (cb * (1 - cb) * fifth(1 - cb));
            return schlick(p[0], c) - dip * (schlick(p[0], cb) - p[1]);
        },
        "dielectric": (p, c) => conductor(p[0], 0, c),
        "conductor": (p, c) => conductor(p[0], p[1], c),
        "schlick-karis": (p, c) => { const m = 2 ** ((-5.55473 * c - 6.98316) * c); return m + (1 - m) * p[0]; },
        "cycles": (p, c) => 1 - (1 - p[0]) * (1 - conductor(p[1], 0, c)) / (1 - ((p[1] - 1) / (p[1] + 1)) ** 2),
        "sgd": (p, c) => schlick(p[0], c) - p[1] * c,
        "none": () => 1,
    };

    /* ---- diffuse terms --------------------------------------------------------------------------------------------------------- */

    const enters = z => 1 - fifth(1 - z);
    function burley(kd, rough, g) {
        const rise = 2 * rough * g.c * g.c - 0.5;
        return kd / Math.PI * (1 + rise * fifth(1 - g.iz)) * (1 + rise * fifth(1 - g.oz));
    }
    const saturating = (factor, offset, sigma) => factor * sigma * sigma / (sigma * sigma + offset);
    function orenNayar(kd, sigma, g) {
        const low = Math.min(g.iz, g.oz), high = Math.max(g.iz, g.oz), alpha = Math.acos(Math.min(low, 1)), beta = Math.acos(Math.min(high, 1));
        const sa = Math.sin(alpha), sb = Math.sin(beta), a = 2 / Math.PI * alpha, b = 2 / Math.PI * beta, sines = sa * sb;
        const phi = sines > 1e-30 ? clamp((2 * g.c * g.c - 1 - low * high) / sines, -1, 1) : 1;
        const sum = 1 + saturating(-0.5, 0.33, sigma) +
            saturating(0.45, 0.09, sigma) * phi * (sa - (phi < 0 ? b * b * b : 0)) * sb / high +
            saturating(0.125, 0.09, sigma) * (1 - Math.abs(phi)) * (a * b) ** 2 * (sa + sb) / (low + high) +
            kd * saturating(0.17, 0.13, sigma) * (1 - phi * b * b);
        return positive(kd / Math.PI * sum);
    }
    function towards(g) {
        const s = 2 * g.c * g.c - 1 - g.iz * g.oz;
        return s > 0 ? s / Math.max(g.iz, g.oz) : s;
    }
    const A1 = 0.5 - 2 / (3 * Math.PI), A2 = 2 / 3 - 28 / (15 * Math.PI);
    function deficit(z) {
        const theta = Math.acos(Math.min(z, 1)), s = Math.sin(theta), rim = s * z * (1 + s + s * s) / (1 + s);
        return A1 - (s * (theta - s * z) + 2 / 3 * (rim - s)) / Math.PI;
    }
    function eon(rho, r, g) {
        const A = 1 / (1 + A1 * r), mean = A * (1 + A2 * r), multiple = rho * rho * mean / (1 - rho * (1 - mean));
        return A / Math.PI * (rho * (1 + r * towards(g)) + multiple * r * deficit(g.iz) * deficit(g.oz) / (A1 - A2));
    }
    function hammon(albedo, alpha, g) {
        const facing = g.c * g.c, rough = facing * (0.9 - 0.4 * facing) * (1 + g.c / (g.iz + g.oz)) / Math.PI;
        const smooth = 1.05 / Math.PI * enters(g.iz) * enters(g.oz);
        return albedo * (smooth + Math.min(alpha, 1) * (rough - smooth + albedo * 0.1159));
    }
    /* (1 + (d / L)^2)^power, d = 2 (wi.h) sin(theta_h) */
    const shoulder = (L, power, g) => Math.exp(power * Math.log1p(4 * g.c * g.c * g.s2 / ((1 + g.s2) * L * L)));
    /* p: parameters in the order of the term; of: {alpha, f0} of the first lobe */
    const diffuses = {
        "lambert": p => p[0] / Math.PI,
        "oren-nayar": (p, g) => orenNayar(p[0], p[1], g),
        "oren-nayar-qualitative": (p, g) => p[0] / Math.PI * (1 + saturating(-0.5, 0.33, p[1]) + saturating(0.45, 0.09, p[1]) * positive(towards(g))),
        "eon": (p, g) => eon(p[0], p[1], g),
        "disney": (p, g) => burley(p[0], p[1], g),
        "disney-coupled": (p, g, of) => burley(p[0], Math.sqrt(of.alpha), g),
        "hammon": (p, g, of) => hammon(p[0], of.alpha, g),
        "shirley-coupled": (p, g, of) => 1.05 / Math.PI * enters(g.iz) * enters(g.oz) * p[0] * positive(1 - of.f0),
        "abg": (p, g) => p[0] / (p[1] + Math.max(4 * g.c * g.c * g.s2 / (1 + g.s2), 1e-280) ** (0.5 * p[2])),
        "harvey-shack": (p, g) => p[0] * shoulder(p[1], 0.5 * p[2], g),
        "k-correlation": (p, g) => p[0] * g.iz * g.oz * shoulder(p[1], -0.5 * (p[2] + 1), g),
    };

    /* ---- a model --------------------------------------------------------------------------------------------------------------- */

    /* Can it be evaluated here? */
    function offers(model) {
        return model.lobes.every(l => (l.ndf in stretched || l.ndf in widths) && l.masking in maskings && l.fresnel in fresnels) &&
            model.bases.every(b => b.diffuse in diffuses);
    }

    function stretchOf(lobe, p) {
        const masked = lobe.masking_parameter ? 1 : 0, shared = lobe.share ? 1 : 0, own = p.length - masked - shared;
        if (!(lobe.ndf in stretched)) {
            const ndf = widths[lobe.ndf](p), a = ndf.stretch ? ndf.alpha : 1;
            return {ndf, ax: a, ay: a, r: 0, x0: 0, y0: 0, alpha: ndf.alpha};
        }
        const [ax, ay, r, x0, y0] = lobe.isotropic ? [p[0], p[0], 0, 0, 0] : p;
        return {ndf: stretched[lobe.ndf](p.slice(lobe.isotropic ? 1 : 5, own)), ax, ay, r, x0, y0, alpha: ax};
    }

    function lobeOf(lobe, values) {
        const p = lobe.shape.map(values), s = stretchOf(lobe, p), masking = maskings[lobe.masking], ndf = s.ndf;
        const x = masking.alpha ? s.ax : lobe.masking_parameter ? values(lobe.masking_parameter) : 0;
        const lambda = masking.smith ? ndf.lambda || tabled(ndf) : () => 0;
        const inv = 1 / (1 - s.r * s.r), xx = inv / (s.ax * s.ax), yy = inv / (s.ay * s.ay), xy = -s.r * inv / (s.ax * s.ay);
        const norm = 1 / (s.ax * s.ay * Math.sqrt(1 - s.r * s.r)), Sxy = 2 * s.r * s.ax * s.ay;
        const spread = (tx, ty) => s.ax * s.ax * tx * tx + s.ay * s.ay * ty * ty + Sxy * tx * ty;
        function value(g) {
            const dx = g.sx - s.x0, dy = g.sy - s.y0, q2 = xx * dx * dx + yy * dy * dy + 2 * xy * dx * dy;
            const di = 1 - (g.tix * s.x0 + g.tiy * s.y0), dO = 1 - (g.tox * s.x0 + g.toy * s.y0);
            if (!(di > DEN_MIN) || !(dO > DEN_MIN)) return 0;
            const li = lambda(Math.max(spread(g.tix, g.tiy) / (di * di), 1e-60)), lo = lambda(Math.max(spread(g.tox, g.toy) / (dO * dO), 1e-60));
            return norm * ndf.profile(q2) * masking.G(li, lo, g, x) * g.K / dO;
        }
        /* D of the half vector, 1/sr: hz^-4 = (1 + |s|^2)^2 */
        function D(g) {
            const dx = g.sx - s.x0, dy = g.sy - s.y0;
            return norm * ndf.profile(xx * dx * dx + yy * dy * dy + 2 * xy * dx * dy) * (1 + g.s2) * (1 + g.s2);
        }
        const G = g => masking.G(lambda(Math.max(spread(g.tix, g.tiy), 1e-60)), lambda(Math.max(spread(g.tox, g.toy), 1e-60)), g, x);
        return {value, D, G, alpha: s.alpha, share: lobe.share ? values(lobe.share) : 0, shares: Boolean(lobe.share)};
    }

    /* Weight of each lobe: a later one that shares its Fresnel term takes its share of what is there. */
    function weigh(lobes) {
        lobes.forEach((lobe, l) => {
            lobe.weight = lobe.shares ? lobe.share : 1;
            if (l > 0 && !lobe.shares) return;
            for (const later of lobes.slice(l + 1)) if (later.shares) lobe.weight *= 1 - later.share;
        });
    }

    /* What no parameter changes of a pair of directions; null below the horizon. */
    function geometry(wix, wiy, wiz, wox, woy, woz) {
        if (!(wiz > COS_MIN) || !(woz > COS_MIN)) return null;
        const hx = wix + wox, hy = wiy + woy, hz = wiz + woz, sx = -hx / hz, sy = -hy / hz, s2 = sx * sx + sy * sy;
        const tix = wix / wiz, tiy = wiy / wiz, tox = wox / woz, toy = woy / woz, dot = tix * tox + tiy * toy, cross = Math.abs(tix * toy - tiy * tox);
        return {iz: wiz, oz: woz, sx, sy, s2, tix, tiy, tox, toy, c: 0.5 * Math.sqrt(hx * hx + hy * hy + hz * hz),
            K: 0.25 / (wiz * woz) * (1 + s2) * (1 + s2), phi: dot * dot + cross * cross > 0 ? Math.atan2(cross, dot) : 0};
    }

    /* values(name, channel): the number of a parameter; channel is left out for what all share. Gives f(geometry, channel) in 1/sr,
     * parts(geometry, channel): {lobes: [...], base}, and D, G, F of the first lobe. */
    function compile(model, values, channels) {
        const lobes = model.lobes.map(lobe => lobeOf(lobe, name => values(name)));
        weigh(lobes);
        const perChannel = [];
        for (let c = 0; c < channels; c++) {
            const groups = model.lobes.map(l => ({F: fresnels[l.fresnel], p: l.fresnel_parameters.map(n => values(n, c)), ks: l.ks ? values(l.ks, c) : 1}));
            const of = {alpha: lobes.length ? lobes[0].alpha : 0, f0: lobes.length ? groups[0].F(groups[0].p, 1) : 0};
            perChannel.push({groups, of, bases: model.bases.map(b => ({f: diffuses[b.diffuse], p: b.parameters.map(n => values(n, c))}))});
        }
        const reflected = (k, g, c) => {
            const group = perChannel[c].groups[model.lobes[k].group];
            return lobes[k].weight * group.ks * group.F(group.p, g.c);
        };
        const under = (g, c) => perChannel[c].bases.reduce((sum, b) => sum + b.f(b.p, g, perChannel[c].of), 0);
        function f(g, c) {
            if (!g) return 0;
            let sum = 0;
            for (let k = 0; k < lobes.length; k++) sum += lobes[k].value(g) * reflected(k, g, c);
            return sum + under(g, c);
        }
        /* All channels at once: the lobes are the same in each. out [channels] */
        function all(g, out) {
            out.fill(0);
            if (!g) return out;
            for (let k = 0; k < lobes.length; k++) {
                const S = lobes[k].value(g);
                for (let c = 0; c < channels; c++) out[c] += S * reflected(k, g, c);
            }
            for (let c = 0; c < channels; c++) out[c] += under(g, c);
            return out;
        }
        const parts = (g, c) => ({lobes: lobes.map((lobe, k) => g ? lobe.value(g) * reflected(k, g, c) : 0), base: g ? under(g, c) : 0});
        const first = lobes.length ? lobes[0] : null;
        const F = (g, c) => perChannel[c].groups[0].ks * perChannel[c].groups[0].F(perChannel[c].groups[0].p, g.c);
        return {f, all, parts, D: first && first.D, G: first && first.G, F};
    }

    const direction = (theta, phi) => [Math.sin(theta) * Math.cos(phi), Math.sin(theta) * Math.sin(phi), Math.cos(theta)];
    const pair = (ti, pi, to, po) => geometry(...direction(ti, pi), ...direction(to, po));

    return {offers, compile, geometry, pair, direction};
})();
if (typeof module !== "undefined") module.exports = Model;
