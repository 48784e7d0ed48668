/* What is done with models: samples, albedos, simulated data, noise, conversions, figures. */
#include "model.h"
#include "table.h"
#include <cmath>
#include "ff_albedo.h"
#include "ff_aperture.h"
#include "ff_convert.h"
#include "ff_sample.h"
#include "ff_simulate.h"
#include "ff_version.h"

namespace bind
{
namespace
{
using text = std::optional<std::string>;

/* ---- noise ----------------------------------------------------------------------------------- */

std::shared_ptr<noise> new_noise(const std::vector<std::array<double, 3>> &levels, double cos_i, double cos_o)
{
    std::vector<ff_noise_level> level;
    for (const auto &l : levels) level.push_back({l[0], l[1], l[2]});
    ff_noise *n = nullptr;
    ff_error err = {};
    check(ff_noise_new(level.data(), level.size(), cos_i, cos_o, &n, &err), err);
    auto made = std::make_shared<noise>();
    made->n.reset(n);
    return made;
}

std::vector<std::array<double, 3>> levels_of(const noise &self)
{
    std::vector<std::array<double, 3>> all;
    for (size_t c = 0; c < ff_noise_level_count(self.n.get()); c++) {
        const ff_noise_level l = ff_noise_level_at(self.n.get(), c);
        all.push_back({l.constant, l.linear, l.square});
    }
    return all;
}

py::array sd(const noise &self, const numbers &f, const numbers &cos_i, const numbers &cos_o, size_t channel)
{
    const ff_noise *n = self.n.get();
    return py::vectorize([n, channel](double x, double i, double o) { return ff_noise_sd(n, channel, x, i, o); })(f, cos_i, cos_o);
}

/* ---- samples and albedos --------------------------------------------------------------------- */

/* Directions wi for each wo, with their density and weights: uniform numbers of streams 0 to 2 of the seed. */
py::tuple sample(const model &self, const py::object &wo, uint64_t seed, const py::kwargs &said)
{
    const direction_pairs w(wo, wo);
    const values v = self.with(said);
    const size_t n = w.n();
    ff_sampler *s = nullptr;
    ff_error err = {};
    ff_status status;
    std::unique_ptr<double[]> u(new double[3 * n + 1]), wi(new double[3 * n + 1]), pdf(new double[n + 1]),
        f(new double[v.channels * n + 1]), weight(new double[v.channels * n + 1]);
    {
        const py::gil_scoped_release others_may;
        status = ff_sampler_new(self.m.get(), FF_ISA_BEST, v.channels, v.shape.data(), v.channel.data(), &s, &err);
        if (status == FF_OK) {
            for (uint32_t k = 0; k < 3; k++)
                for (size_t i = 0; i < n; i++) u[k * n + i] = ff_random_uniform(seed, k, i);
            ff_sampler_sample(s, n, w.dirs()->wox, u.get(), nullptr, wi.get(), pdf.get(), f.get(), weight.get(), n);
            ff_sampler_free(s);
        }
    }
    check(status, err);
    std::vector<py::ssize_t> vectors = w.shape(1);
    vectors.push_back(3);
    return py::make_tuple(planes_array(std::move(wi), vectors, 3, n), planes_array(std::move(pdf), w.shape(1), 1, n),
                          planes_array(std::move(weight), w.shape(v.channels), v.channels, n),
                          planes_array(std::move(f), w.shape(v.channels), v.channels, n));
}

py::array pdf_of(const model &self, const py::object &wi, const py::object &wo, const py::kwargs &said)
{
    const direction_pairs w(wi, wo);
    const values v = self.with(said);
    ff_sampler *s = nullptr;
    ff_error err = {};
    ff_status status;
    std::unique_ptr<double[]> pdf(new double[w.n() + 1]);
    {
        const py::gil_scoped_release others_may;
        status = ff_sampler_new(self.m.get(), FF_ISA_BEST, v.channels, v.shape.data(), v.channel.data(), &s, &err);
        if (status == FF_OK) {
            ff_sampler_pdf(s, w.n(), w.dirs()->wox, w.dirs()->wix, pdf.get(), w.n());
            ff_sampler_free(s);
        }
    }
    check(status, err);
    return planes_array(std::move(pdf), w.shape(1), 1, w.n());
}

/* Values and errors, in the shape of wo and the channels. */
py::tuple albedo(const model &self, const py::object &wo, const py::kwargs &said)
{
    const direction_pairs w(wo, wo);
    const values v = self.with(said);
    const size_t n = w.n();
    std::unique_ptr<double[]> value(new double[v.channels * n + 1]), error(new double[v.channels * n + 1]);
    std::vector<ff_integral> one(v.channels);
    ff_error err = {};
    ff_status status = FF_OK;
    {
        const py::gil_scoped_release others_may;
        for (size_t i = 0; i < n && status == FF_OK; i++) {
            const double of[3] = {w.dirs()->wox[i], w.dirs()->woy[i], w.dirs()->woz[i]};
            status = ff_albedo_directional(self.m.get(), FF_ISA_BEST, v.channels, v.shape.data(), v.channel.data(), of, one.data(),
                                           &err);
            for (size_t c = 0; c < v.channels && status == FF_OK; c++) {
                value[c * n + i] = one[c].value;
                error[c * n + i] = one[c].error;
            }
        }
    }
    check(status, err);
    return py::make_tuple(planes_array(std::move(value), w.shape(v.channels), v.channels, n),
                          planes_array(std::move(error), w.shape(v.channels), v.channels, n));
}

/* ---- simulated data -------------------------------------------------------------------------- */

std::unique_ptr<table> simulate(const model &self, const std::string &grid, double relative, double floor,
                                const std::shared_ptr<noise> &of, uint64_t seed, bool sigma, const text &aperture,
                                const py::kwargs &said)
{
    const values v = self.with(said);
    ff_aperture a = {};
    ff_simulate_options o;
    ff_error err = {};
    ff_simulate_options_init(&o);
    check(ff_sampling_parse(grid.c_str(), &o.sampling, &err), err);
    if (aperture) check(ff_aperture_parse(aperture->c_str(), &a), {});
    o.relative = relative;
    o.floor = floor;
    o.noise = of ? of->n.get() : nullptr;
    o.seed = seed;
    o.sigma = sigma;
    o.aperture = &a;
    ear ears;
    o.cancel = &ears.cancel;
    ff_table *t = nullptr;
    ff_status status = FF_OK;
    ears.work([&] { status = ff_simulate(self.m.get(), v.channels, v.shape.data(), v.channel.data(), &o, &t, &err); }, py::none());
    check(status, err);
    return make_table(t, "simulated");
}

/* ---- conversions ----------------------------------------------------------------------------- */

py::dict step_dict(const ff_conversion *c)
{
    py::dict d;
    d["from"] = c->from;
    d["to"] = c->to;
    d["by"] = c->by;
    d["formula"] = c->formula;
    d["source"] = c->source;
    d["assumes"] = c->assumes;
    d["limits"] = c->limits;
    d["matches"] = (bool)c->matches;
    return d;
}

/* The numbers that go in, by their names or other names. */
std::vector<double> arguments_of(const ff_conversion *c, const py::dict &said)
{
    std::vector<double> in;
    size_t used = 0;
    std::string names;
    for (uint32_t k = 0; k < c->n_in; k++) {
        const ff_conversion_value &v = c->in[k];
        names += (k ? ", " : "") + std::string(v.name);
        const char *key = said.contains(v.name) ? v.name : v.alias && said.contains(v.alias) ? v.alias : nullptr;
        if (!key && !v.optional) throw py::type_error(std::string(c->from) + ": " + v.name + " is missing");
        used += key != nullptr;
        in.push_back(key ? py::cast<double>(said[key]) : v.initial);
    }
    if (used != said.size()) throw py::type_error(std::string(c->from) + " has the arguments " + names + " and no other");
    return in;
}

/* ({name: value}, [steps], doubt or None) of each way. */
py::list convert(const std::string &from, const std::string &to, const text &by, double theta_i, const py::dict &said)
{
    enum { MOST = 16 };
    const char *a = ff_conversion_name(from.c_str()), *b = ff_conversion_name(to.c_str());
    ff_conversion_path path[MOST];
    ff_error err = {};
    if (!a || !b)
        check(ff_error_set(&err, FF_ERR_UNKNOWN, nullptr, 0, -1, "no convention '%.40s'; facetfit.conversions() lists them",
                           (a ? to : from).c_str()),
              err);
    const size_t n = ff_conversion_paths(a, b, by ? by->c_str() : nullptr, MOST, path);
    if (!n)
        check(ff_error_set(&err, FF_ERR_UNSUPPORTED, nullptr, 0, -1, "there is no way from %s to %s%s%.40s", a, b, by ? " by " : "",
                           by ? by->c_str() : ""),
              err);
    py::list all;
    for (size_t k = 0; k < n; k++) {
        const ff_conversion *last = path[k].step[path[k].n - 1];
        const std::vector<double> in = arguments_of(path[k].step[0], said);
        double out[FF_CONVERSION_VALUES] = {};
        const char *doubt = nullptr;
        check(ff_conversion_follow(&path[k], in.data(), theta_i, out, &doubt, &err), err);
        py::dict found;
        py::list steps;
        for (uint32_t j = 0; j < last->n_out; j++) found[last->out[j].name] = out[j];
        for (size_t j = 0; j < path[k].n; j++) steps.append(step_dict(path[k].step[j]));
        all.append(py::make_tuple(found, steps, doubt ? py::object(py::str(doubt)) : py::none()));
    }
    return all;
}

py::list conversions()
{
    py::list all;
    for (size_t i = 0; i < ff_conversion_count(); i++) all.append(step_dict(ff_conversion_at(i)));
    return all;
}

std::vector<std::string> names(const char *(*at)(size_t))
{
    std::vector<std::string> all;
    for (size_t i = 0; at(i); i++) all.push_back(at(i));
    return all;
}
} // namespace

void add_tools(py::module_ &m)
{
    py::class_<noise, std::shared_ptr<noise>>(m, "Noise")
        .def(py::init(&new_noise), py::arg("levels"), py::arg("cos_i"), py::arg("cos_o"))
        .def_property_readonly("levels", levels_of)
        .def_property_readonly("cos_i", [](const noise &n) { return ff_noise_cos_i(n.n.get()); })
        .def_property_readonly("cos_o", [](const noise &n) { return ff_noise_cos_o(n.n.get()); })
        .def("sd", sd, py::arg("f"), py::arg("cos_i") = 1.0, py::arg("cos_o") = 1.0, py::arg("channel") = 0);
    m.def("sample", sample, py::arg("model"), py::arg("wo"), py::arg("seed"), py::pos_only());
    m.def("pdf", pdf_of, py::arg("model"), py::arg("wi"), py::arg("wo"), py::pos_only());
    m.def("albedo", albedo, py::arg("model"), py::arg("wo"), py::pos_only());
    m.def("simulate", simulate, py::arg("model"), py::arg("grid"), py::arg("relative"), py::arg("floor"), py::arg("noise"),
          py::arg("seed"), py::arg("sigma"), py::arg("aperture"), py::pos_only());
    m.def("convert", convert, py::arg("start"), py::arg("to"), py::arg("by"), py::arg("theta_i"), py::arg("said"));
    m.def("conversions", conversions);
    m.def("plot_kinds", [] { return names(ff_plot_name); });
    m.def("export_names", [] { return names(ff_export_name); });
    m.def("version", [] { return ff_version(); });
}
} // namespace bind
