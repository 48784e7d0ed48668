/* Models: their parameters, their values and derivatives. */
#include "model.h"
#include <algorithm>
#include <cmath>
#include <cstring>
#include "ff_model.h"
#include "ff_profile_file.h"

namespace bind
{
namespace
{
/* ---- values of parameters -------------------------------------------------------------------- */

/* How many channels a value speaks of: 1 of a number. */
size_t length_of(const py::handle &said)
{
    if (PyFloat_Check(said.ptr()) || PyLong_Check(said.ptr())) return 1;
    if (!PySequence_Check(said.ptr()) || PyUnicode_Check(said.ptr())) return 1;
    const Py_ssize_t n = PySequence_Size(said.ptr());
    if (n < 0) PyErr_Clear(); /* an array without axes */
    return n > 0 ? (size_t)n : 1;
}

/* A number, or one of each channel. */
void numbers_of(const py::handle &said, const char *name, std::vector<double> &out)
{
    out.clear();
    if (PyFloat_Check(said.ptr()) || PyLong_Check(said.ptr())) {
        const double x = PyFloat_AsDouble(said.ptr());
        if (x == -1 && PyErr_Occurred()) throw py::error_already_set();
        out.push_back(x);
        return;
    }
    const bool is_word = PyUnicode_Check(said.ptr()) || said.is_none();
    const numbers a = is_word ? numbers() : numbers::ensure(said);
    if (is_word || !a || a.ndim() > 1 || a.size() == 0) {
        PyErr_Clear();
        throw py::type_error(std::string(name) + ": expected a number, or a sequence with one for each channel");
    }
    out.assign(a.data(), a.data() + a.size());
}

/* The library's own words for a name that the model lacks. */
void unknown(const ff_model *m, const char *name)
{
    ff_error err = {};
    std::vector<double> shape(ff_model_param_count(m, FF_PARAM_SHAPE) + 1), channel(ff_model_param_count(m, FF_PARAM_CHANNEL) + 1);
    check(ff_model_set(m, 1, (std::string(name) + "=0").c_str(), shape.data(), channel.data(), &err), err);
    throw py::key_error(name);
}

/* "alpha" and "lobe2.alpha" are both axes, where the model has no such parameter. */
bool ends_with_alpha(const char *name)
{
    const size_t n = std::strlen(name);
    return n >= 5 && !std::strcmp(name + n - 5, "alpha") && (n == 5 || name[n - 6] == '.');
}
} // namespace

void model::set(values &v, const char *name, const py::handle &said) const
{
    thread_local std::vector<double> x;
    ff_param_ref ref[2] = {ff_model_param_find(m.get(), name), {FF_PARAM_NONE, 0}};
    if (ref[0].kind == FF_PARAM_NONE && ends_with_alpha(name)) {
        ref[0] = ff_model_param_find(m.get(), (std::string(name) + "_x").c_str());
        ref[1] = ff_model_param_find(m.get(), (std::string(name) + "_y").c_str());
    }
    if (ref[0].kind == FF_PARAM_NONE) unknown(m.get(), name);
    numbers_of(said, name, x);
    for (const ff_param_ref &r : ref) {
        if (r.kind == FF_PARAM_NONE) continue;
        if (r.kind == FF_PARAM_SHAPE && x.size() != 1)
            throw py::value_error(std::string(name) + ": it has one value for all channels");
        if (r.kind == FF_PARAM_SHAPE) {
            v.shape[r.index] = x[0];
            continue;
        }
        if (x.size() != 1 && x.size() != v.channels)
            throw py::value_error(std::string(name) + ": expected 1 or " + std::to_string(v.channels) + " values, found " +
                                  std::to_string(x.size()));
        const size_t own = count(FF_PARAM_CHANNEL);
        for (size_t c = 0; c < v.channels; c++) v.channel[c * own + r.index] = x[x.size() == 1 ? 0 : c];
    }
}

/* What there is once is there in every channel of more. */
static void widen(values &v, size_t channels, size_t own)
{
    if (channels <= v.channels) return;
    if (v.channels != 1)
        throw py::value_error("the model has values in " + std::to_string(v.channels) + " channels, and " +
                              std::to_string(channels) + " are given");
    const std::vector<double> one = v.channel;
    v.channel.resize(channels * own);
    for (size_t c = 1; c < channels; c++)
        std::copy(one.begin(), one.begin() + (std::ptrdiff_t)own, v.channel.begin() + (std::ptrdiff_t)(c * own));
    v.channels = channels;
}

values model::with(const py::kwargs &said) const
{
    values v = own;
    size_t channels = 1;
    for (const auto &item : said) channels = std::max(channels, length_of(item.second));
    widen(v, channels, count(FF_PARAM_CHANNEL));
    for (const auto &item : said) {
        const char *name = PyUnicode_AsUTF8(item.first.ptr());
        if (!name) throw py::error_already_set();
        set(v, name, item.second);
    }
    return v;
}

values found_values(const ff_fit_result *fit)
{
    const ff_model *m = ff_fit_result_model(fit);
    values v;
    v.channels = ff_fit_result_channel_count(fit);
    v.shape.resize(ff_model_param_count(m, FF_PARAM_SHAPE) + 1);
    v.channel.resize(v.channels * ff_model_param_count(m, FF_PARAM_CHANNEL) + 1);
    ff_fit_result_values(fit, v.shape.data(), v.channel.data());
    v.channel.resize(v.channels * ff_model_param_count(m, FF_PARAM_CHANNEL));
    return v;
}

/* ---- making ---------------------------------------------------------------------------------- */

static void set_defaults(model &made)
{
    made.own.channels = 1;
    made.own.shape.resize(made.count(FF_PARAM_SHAPE));
    made.own.channel.resize(made.count(FF_PARAM_CHANNEL));
    ff_model_defaults(made.m.get(), 1, made.own.shape.data(), made.own.channel.data());
}

std::shared_ptr<model> copy_model(const ff_model *m, const std::shared_ptr<profile> &table)
{
    ff_model *copy = nullptr;
    ff_error err = {};
    check(ff_model_copy(m, &copy, &err), err);
    auto made = std::make_shared<model>();
    made->m.reset(copy);
    made->table = table;
    set_defaults(*made);
    return made;
}

namespace
{
void check_values(const model &self, const values &v)
{
    ff_error err = {};
    check(ff_model_check(self.m.get(), v.channels, v.shape.data(), v.channel.data(), &err), err);
}

/* An evaluation says no more than that something is wrong: here it is what. */
void check_call(const model &self, const values &v, ff_status status)
{
    if (status == FF_OK) return;
    check_values(self, v);
    check(status, {});
}

std::shared_ptr<model> new_model(const std::string &expression, const std::shared_ptr<profile> &table, const py::kwargs &said)
{
    ff_model *m = nullptr;
    ff_error err = {};
    check(ff_model_new(expression.c_str(), &m, &err), err);
    auto made = std::make_shared<model>();
    made->m.reset(m);
    made->table = table;
    if (table) ff_model_set_table(m, table->t.get());
    set_defaults(*made);
    made->own = made->with(said);
    check_values(*made, made->own);
    return made;
}

std::shared_ptr<model> with_values(const model &self, const py::kwargs &said)
{
    auto made = copy_model(self.m.get(), self.table);
    made->own = self.with(said);
    check_values(*made, made->own);
    return made;
}

std::string expression_of(const model &self)
{
    char text[FF_MODEL_NAME];
    ff_model_expression(self.m.get(), text, sizeof text);
    return text;
}

/* Shared ones first: (name, meaning, unit, per channel, held, lo, hi, value or values). */
py::list parameters_of(const model &self)
{
    py::list all;
    for (const ff_param_kind kind : {FF_PARAM_SHAPE, FF_PARAM_CHANNEL})
        for (uint32_t k = 0; k < self.count(kind); k++) {
            const ff_model_param *p = ff_model_param_at(self.m.get(), {kind, k});
            const bool by_channel = kind == FF_PARAM_CHANNEL;
            py::array_t<double> value((py::ssize_t)(by_channel ? self.own.channels : 1));
            for (size_t c = 0; c < (size_t)value.size(); c++)
                value.mutable_data()[c] = by_channel ? self.own.channel[c * self.count(kind) + k] : self.own.shape[k];
            all.append(py::make_tuple(p->name, p->info->meaning, p->info->unit, by_channel, (p->flags & FF_PARAM_HELD) != 0, p->lo,
                                      p->hi, value));
        }
    return all;
}

/* ---- evaluation ------------------------------------------------------------------------------ */

ff_status evaluate(const model &self, const values &v, const direction_pairs &w, double *f, double *df)
{
    return ff_model_eval(self.m.get(), FF_ISA_BEST, v.channels, v.shape.data(), v.channel.data(), w.dirs(), w.n(), f, df, w.n());
}

py::array call(const model &self, const py::object &wi, const py::object &wo, const py::kwargs &said)
{
    const direction_pairs w(wi, wo);
    const values v = self.with(said);
    std::unique_ptr<double[]> f(new double[v.channels * w.n() + 1]);
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = evaluate(self, v, w, f.get(), nullptr);
    }
    check_call(self, v, status);
    return planes_array(std::move(f), w.shape(v.channels), v.channels, w.n());
}

/* Planes [channels] that lie `step` planes apart, as an array. */
py::array taken(const double *planes, size_t step, const direction_pairs &w, size_t channels)
{
    std::unique_ptr<double[]> own(new double[channels * w.n() + 1]);
    for (size_t c = 0; c < channels; c++)
        std::copy(planes + c * step * w.n(), planes + (c * step + 1) * w.n(), own.get() + c * w.n());
    return planes_array(std::move(own), w.shape(channels), channels, w.n());
}

/* f, and {name: d f / d parameter}. */
py::tuple gradient(const model &self, const py::object &wi, const py::object &wo, const py::kwargs &said)
{
    const direction_pairs w(wi, wo);
    const values v = self.with(said);
    const size_t shape = self.count(FF_PARAM_SHAPE), columns = shape + self.count(FF_PARAM_CHANNEL);
    std::unique_ptr<double[]> f(new double[v.channels * w.n() + 1]), df(new double[v.channels * columns * w.n() + 1]);
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = evaluate(self, v, w, f.get(), df.get());
    }
    check_call(self, v, status);
    py::dict all;
    for (size_t k = 0; k < columns; k++) {
        const ff_param_ref ref =
            k < shape ? ff_param_ref{FF_PARAM_SHAPE, (uint32_t)k} : ff_param_ref{FF_PARAM_CHANNEL, (uint32_t)(k - shape)};
        all[ff_model_param_at(self.m.get(), ref)->name] = taken(df.get() + k * w.n(), columns, w, v.channels);
    }
    return py::make_tuple(planes_array(std::move(f), w.shape(v.channels), v.channels, w.n()), all);
}

/* D, Lambda of both directions, G2 and F of a lobe. */
py::dict terms(const model &self, const py::object &wi, const py::object &wo, uint32_t lobe, size_t channel, const py::kwargs &said)
{
    const direction_pairs w(wi, wo);
    const values v = self.with(said);
    std::unique_ptr<double[]> plane[5];
    for (auto &p : plane) p.reset(new double[w.n() + 1]);
    const ff_terms out = {plane[0].get(), plane[1].get(), plane[2].get(), plane[3].get(), plane[4].get()};
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = ff_model_terms(self.m.get(), FF_ISA_BEST, v.channels, v.shape.data(), v.channel.data(), lobe, channel, w.dirs(),
                                w.n(), &out);
    }
    check_call(self, v, status);
    static const char *const name[] = {"D", "Lambda_i", "Lambda_o", "G", "F"};
    py::dict all;
    for (size_t k = 0; k < 5; k++) all[name[k]] = planes_array(std::move(plane[k]), w.shape(1), 1, w.n());
    return all;
}

/* ---- constraints ----------------------------------------------------------------------------- */

void hold(model &self, const std::string &name, double value)
{
    ff_error err = {};
    check(ff_model_hold(self.m.get(), name.c_str(), value, &err), err);
}

void vary(model &self, const std::string &name)
{
    ff_error err = {};
    check(ff_model_vary(self.m.get(), name.c_str(), &err), err);
}

/* ---- profiles -------------------------------------------------------------------------------- */

std::shared_ptr<profile> new_profile(const numbers &x, const numbers &y, bool of_slopes)
{
    if (x.size() != y.size()) throw py::value_error("expected as many values as angles");
    ff_profile_table *t = nullptr;
    ff_error err = {};
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = ff_profile_new(of_slopes ? FF_PROFILE_P : FF_PROFILE_D, (size_t)x.size(), x.data(), y.data(), &t, nullptr, &err);
    }
    check(status, err);
    auto made = std::make_shared<profile>();
    made->t.reset(t);
    return made;
}

std::shared_ptr<profile> read_profile(const std::string &path)
{
    ff_profile_table *t = nullptr;
    ff_error err = {};
    check(ff_profile_read(path.c_str(), &t, &err), err);
    auto made = std::make_shared<profile>();
    made->t.reset(t);
    return made;
}

py::dict term_dict(const ff_term *t, const char *kind)
{
    py::dict d;
    py::list params;
    for (uint32_t k = 0; k < t->n_params; k++) params.append(t->params[k].name);
    d["kind"] = kind;
    d["name"] = t->name;
    d["title"] = t->title;
    d["source"] = t->source;
    d["note"] = t->note;
    d["parameters"] = params;
    d["furnace_only"] = (t->claims & FF_FURNACE_ONLY) != 0;
    return d;
}

py::list models()
{
    py::list all;
    for (int kind = 0; kind < FF_TERM_KINDS; kind++)
        for (size_t i = 0; i < ff_term_count((ff_term_kind)kind); i++)
            all.append(term_dict(ff_term_at((ff_term_kind)kind, i), ff_term_kind_name((ff_term_kind)kind)));
    for (size_t i = 0; i < ff_preset_count(); i++) {
        const ff_preset *p = ff_preset_at(i);
        py::dict d;
        d["kind"] = "preset";
        d["name"] = p->name;
        d["title"] = p->title;
        d["source"] = p->source;
        d["note"] = p->note;
        d["expression"] = p->expression;
        all.append(d);
    }
    return all;
}
} // namespace

void add_models(py::module_ &m)
{
    py::class_<profile, std::shared_ptr<profile>>(m, "Profile")
        .def(py::init(&new_profile), py::arg("x"), py::arg("y"), py::arg("of_slopes") = false)
        .def_static("read", read_profile, py::arg("path"));
    py::class_<model, std::shared_ptr<model>> c(m, "Model");
    c.def(py::init(&new_model), py::arg("expression"), py::pos_only(), py::arg("table") = nullptr);
    c.def_property_readonly("expression", expression_of);
    c.def_property_readonly("channels", [](const model &self) { return self.own.channels; });
    c.def("_parameters", parameters_of);
    c.def("_with", with_values);
    c.def("_hold", hold, py::arg("name"), py::arg("value"));
    c.def("_vary", vary, py::arg("name"));
    c.def("__call__", call, py::arg("wi"), py::arg("wo"), py::pos_only());
    c.def("gradient", gradient, py::arg("wi"), py::arg("wo"), py::pos_only());
    c.def("terms", terms, py::arg("wi"), py::arg("wo"), py::pos_only(), py::arg("lobe") = 0, py::arg("channel") = 0);
    m.def("models", models);
}
} // namespace bind
