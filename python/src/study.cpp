/* Fits: made, looked at, written, drawn, exported. */
#include "model.h"
#include "options.h"
#include "table.h"
#include <cmath>
#include <mutex>
#include "ff_words.h"

namespace bind
{
namespace
{
using text = std::optional<std::string>;

/* A study, with all that it borrows. */
struct study {
    explicit study(const py::dict &o) : asked_of_fits(o)
    {
    }
    py::object measured; /* keeps the table */
    std::vector<std::shared_ptr<model>> models;
    asking asked_of_fits;
    ff_study_options asked;
    std::mutex one_at_a_time;
    study_ptr s;
};

/* One call at a time on a study: waits for its turn without the interpreter's lock. */
class turn
{
  public:
    explicit turn(study &s) : hold(s.one_at_a_time, std::defer_lock)
    {
        const py::gil_scoped_release others_may;
        hold.lock();
    }

  private:
    std::unique_lock<std::mutex> hold;
};

/* ---- options --------------------------------------------------------------------------------- */

void take_study(study &s, const py::dict &o)
{
    ff_study_options &a = s.asked;
    ff_study_options_init(&a);
    a.path = s.asked_of_fits.keep(s.measured.cast<table &>().path);
    if (!o["command"].is_none()) a.command = s.asked_of_fits.keep(py::cast<std::string>(o["command"]));
    a.compare = py::cast<bool>(o["compare"]);
    a.choose_loss = py::cast<bool>(o["choose_loss"]);
    a.bootstrap = py::cast<size_t>(o["bootstrap"]);
    a.seed = py::cast<uint64_t>(o["seed"]);
    a.profile = py::cast<bool>(o["profile"]);
    a.folds = py::cast<size_t>(o["cross_validate"]);
    a.cut_off = py::cast<double>(o["cut_off"]);
    a.reach = py::cast<double>(o["reach"]);
    a.errors_asked = py::cast<bool>(o["errors_asked"]);
    a.busy = ear::hear_busy;
    a.busy_context = &s.asked_of_fits.ears;
}

std::shared_ptr<study> new_study(const py::object &measured, const std::vector<std::shared_ptr<model>> &models, const py::dict &o,
                                 const py::object &progress)
{
    auto s = std::make_shared<study>(o);
    s->measured = measured;
    s->models = models;
    take_study(*s, o);
    std::vector<const ff_model *> all;
    for (const auto &m : models) all.push_back(m->m.get());
    const ff_table *t = measured.cast<table &>().t.get();
    ff_study *made = nullptr;
    ff_error err = {};
    ff_status status = FF_OK;
    s->asked_of_fits.ears.work(
        [&] { status = ff_study_new(t, all.data(), all.size(), &s->asked_of_fits.fit, &s->asked, &made, &err); }, progress);
    check(status, err);
    s->s.reset(made);
    return s;
}

/* ---- what was found -------------------------------------------------------------------------- */

const ff_fit_result *fit_of(const study &s, size_t i)
{
    const ff_fit_result *fit = ff_study_fit(s.s.get(), i);
    if (!fit) throw py::index_error("there is no such fit");
    return fit;
}

size_t problem_number(const study &s, size_t i)
{
    return i / (ff_study_fit_count(s.s.get()) / ff_study_problem_count(s.s.get()));
}

const ff_problem *problem_of(const study &s, size_t i)
{
    return ff_study_problem(s.s.get(), problem_number(s, i));
}

std::vector<std::string> channels_of(const study &s, size_t i)
{
    std::vector<std::string> all;
    for (size_t c = 0; c < ff_fit_result_channel_count(fit_of(s, i)); c++)
        all.push_back(ff_problem_channel_name(problem_of(s, i), c));
    return all;
}

py::tuple value_tuple(const ff_fit_value *v)
{
    return py::make_tuple(v->value, v->std_error, v->low, v->high, ff_interval_name((int)v->interval), v->at_bound, (bool)v->held,
                          (bool)v->tied, v->column, v->carriers, (bool)v->weightless);
}

/* (name, unit, meaning, per channel, [value ...]) of every parameter, with one value for each channel. */
py::list values_of(const study &s, size_t i)
{
    const ff_fit_result *fit = fit_of(s, i);
    const ff_model *m = ff_fit_result_model(fit);
    py::list all;
    for (const ff_param_kind kind : {FF_PARAM_SHAPE, FF_PARAM_CHANNEL})
        for (uint32_t k = 0; k < ff_model_param_count(m, kind); k++) {
            const ff_model_param *p = ff_model_param_at(m, {kind, k});
            const size_t channels = kind == FF_PARAM_SHAPE ? 1 : ff_fit_result_channel_count(fit);
            py::list of;
            for (size_t c = 0; c < channels; c++) of.append(value_tuple(ff_fit_result_at(fit, {kind, k}, c)));
            all.append(py::make_tuple(p->name, p->info->unit, p->info->meaning, kind == FF_PARAM_CHANNEL, of));
        }
    return all;
}

/* Parameters by the columns of the covariance. */
struct column {
    ff_param_ref ref;
    size_t channel;
    std::string name;
    double error;
};

std::vector<column> columns_of(const study &s, size_t i)
{
    const ff_fit_result *fit = fit_of(s, i);
    const ff_model *m = ff_fit_result_model(fit);
    const std::vector<std::string> channels = channels_of(s, i);
    std::vector<column> all;
    for (const ff_param_kind kind : {FF_PARAM_SHAPE, FF_PARAM_CHANNEL})
        for (size_t c = 0; c < (kind == FF_PARAM_SHAPE ? 1 : channels.size()); c++)
            for (uint32_t k = 0; k < ff_model_param_count(m, kind); k++) {
                const ff_param_ref ref = {kind, k};
                const ff_fit_value *v = ff_fit_result_at(fit, ref, c);
                if (v->tied || std::isnan(v->std_error)) continue;
                std::string name = ff_model_param_at(m, ref)->name;
                if (kind == FF_PARAM_CHANNEL && channels.size() > 1) name += "[" + channels[c] + "]";
                all.push_back({ref, c, name, v->std_error});
            }
    return all;
}

py::tuple covariance_of(const study &s, size_t i)
{
    const ff_fit_result *fit = fit_of(s, i);
    const std::vector<column> all = columns_of(s, i);
    const py::ssize_t n = (py::ssize_t)all.size();
    py::array_t<double> a({n, n});
    std::vector<std::string> names;
    for (const column &c : all) names.push_back(c.name);
    for (py::ssize_t k = 0; k < n; k++)
        for (py::ssize_t l = 0; l < n; l++) {
            const column &p = all[(size_t)k], &q = all[(size_t)l];
            const double r = k == l ? 1 : ff_fit_result_correlation(fit, p.ref, p.channel, q.ref, q.channel);
            a.mutable_at(k, l) = r * p.error * q.error;
        }
    return py::make_tuple(names, a);
}

std::string sentence_of(const study &s, size_t i, const ff_warning *w)
{
    const ff_problem *p = problem_of(s, i);
    const ff_fit_result *fit = fit_of(s, i);
    std::string out(ff_words_fit_warning(p, fit, w, nullptr, 0) + 1, '\0');
    ff_words_fit_warning(p, fit, w, &out[0], out.size());
    out.pop_back();
    return out;
}

/* (code, severity, sentence, [parameter ...], [channel ...], {name: value}) */
py::list warnings_of(const study &s, size_t i)
{
    const ff_fit_result *fit = fit_of(s, i);
    const ff_model *m = ff_fit_result_model(fit);
    const std::vector<std::string> channels = channels_of(s, i);
    py::list all;
    for (size_t k = 0; k < ff_fit_result_warning_count(fit); k++) {
        const ff_warning *w = ff_fit_result_warning(fit, k);
        const ff_warning_kind *kind = ff_warning_kind_of((int)w->code);
        py::list parameters, of;
        py::dict numbers;
        for (size_t j = 0; j < w->n_parameters; j++) {
            std::string name = ff_model_param_at(m, w->parameter[j].parameter)->name;
            if (w->parameter[j].channel != FF_NO_CHANNEL && channels.size() > 1)
                name += "[" + channels[w->parameter[j].channel] + "]";
            parameters.append(name);
        }
        for (size_t j = 0; j < w->n_channels; j++) of.append(channels[w->channel[j]]);
        for (size_t j = 0; j < FF_WARNING_VALUES && kind->value[j]; j++) numbers[kind->value[j]] = w->value[j];
        all.append(py::make_tuple(kind->name, ff_severity_name((int)w->severity), sentence_of(s, i, w), parameters, of, numbers));
    }
    return all;
}

py::dict numbers_of(const study &s, size_t i)
{
    const ff_fit_result *fit = fit_of(s, i);
    py::dict d, losses;
    d["objective"] = ff_fit_result_objective(fit);
    d["rmse"] = ff_fit_result_rmse(fit);
    d["max_abs"] = ff_fit_result_max_abs(fit);
    d["aic"] = ff_fit_result_aic(fit);
    d["bic"] = ff_fit_result_bic(fit);
    d["rank"] = ff_fit_result_rank(fit);
    d["condition"] = ff_fit_result_condition(fit);
    d["effective_samples"] = ff_fit_result_effective_samples(fit);
    d["iterations"] = ff_fit_result_iterations(fit);
    d["seconds"] = ff_fit_result_seconds(fit);
    d["free"] = ff_fit_result_free_count(fit);
    for (int k = 0; k < ff_loss_count(); k++) losses[ff_loss_name(k)] = ff_fit_result_loss_rmse(fit, (ff_loss)k);
    d["loss_rmse"] = losses;
    return d;
}

py::object versus_of(const study &s, size_t i)
{
    const ff_versus *v = ff_study_versus(s.s.get(), i);
    if (!v) return py::none();
    py::dict d;
    d["objective"] = v->objective;
    d["aic"] = v->aic;
    d["bic"] = v->bic;
    d["vuong_z"] = v->vuong_z;
    d["vuong_p"] = v->vuong_p;
    d["told_apart"] = (bool)v->told_apart;
    d["by_parameter"] = (bool)v->by_parameter;
    d["validation"] = v->has_validation ? v->validation : NAN;
    d["validation_error"] = v->has_validation ? v->validation_error : NAN;
    return std::move(d);
}

/* Of the samples that the fit used: their places in the table, the model, data and weighted residuals [used][channels], what each
 * adds to the objective. */
py::tuple residuals_of(study &s, size_t i)
{
    const ff_fit_result *fit = fit_of(s, i);
    const ff_problem *p = problem_of(s, i);
    const size_t used = ff_problem_selected(p)->used, channels = ff_fit_result_channel_count(fit);
    std::unique_ptr<double[]> f(new double[used * channels + 1]), r(new double[used * channels + 1]), cost(new double[used + 1]);
    ff_fit_options o = *ff_study_fit_options(s.s.get());
    if (o.channels == FF_CHANNELS_EACH) {
        o.channels = FF_CHANNELS_RGB;
        o.only_channel = (int)problem_number(s, i);
    }
    ff_error err = {};
    ff_status status;
    const turn mine(s);
    {
        const py::gil_scoped_release others_may;
        status = ff_trust_evaluate(p, &o, fit, f.get(), r.get(), cost.get(), &err);
    }
    check(status, err);
    const uint32_t *index = ff_problem_index(p);
    py::array_t<py::ssize_t> at((py::ssize_t)used);
    for (size_t k = 0; k < used; k++) at.mutable_data()[k] = (py::ssize_t)index[k];
    const std::vector<py::ssize_t> shape = {(py::ssize_t)used, (py::ssize_t)channels};
    return py::make_tuple(at, planes_array(std::move(f), shape, channels, used), planes_array(std::move(r), shape, channels, used),
                          planes_array(std::move(cost), {(py::ssize_t)used}, 1, used));
}

py::dict selection_of(const study &s, size_t i)
{
    const ff_selection *k = ff_problem_selected(problem_of(s, i));
    py::dict d;
    d["samples"] = k->samples;
    d["used"] = k->used;
    d["invalid"] = k->invalid;
    d["below_horizon"] = k->below_horizon;
    d["grazing"] = k->grazing;
    d["negative"] = k->negative;
    d["dropped"] = k->dropped;
    d["saturated"] = k->saturated;
    d["below_noise"] = k->below_noise;
    d["copies"] = k->copies;
    return d;
}

py::object noise_of(const study &s, size_t i)
{
    const ff_noise *n = ff_fit_result_noise(fit_of(s, i));
    if (!n) return py::none();
    std::vector<ff_noise_level> level;
    for (size_t c = 0; c < ff_noise_level_count(n); c++) level.push_back(ff_noise_level_at(n, c));
    ff_noise *copy = nullptr;
    ff_error err = {};
    check(ff_noise_new(level.data(), level.size(), ff_noise_cos_i(n), ff_noise_cos_o(n), &copy, &err), err);
    auto made = std::make_shared<noise>();
    made->n.reset(copy);
    return py::cast(made);
}

std::shared_ptr<model> model_of(const study &s, size_t i)
{
    const ff_fit_result *fit = fit_of(s, i);
    std::shared_ptr<profile> tabulated;
    for (const auto &m : s.models)
        if (m->table) tabulated = m->table;
    auto made = copy_model(ff_fit_result_model(fit), tabulated);
    made->own = found_values(fit);
    return made;
}

/* ---- written, drawn, exported ---------------------------------------------------------------- */

py::str write(study &s, const std::string &form)
{
    content c;
    ff_error err = {};
    ff_status status;
    const turn mine(s);
    {
        const py::gil_scoped_release others_may;
        status = ff_study_write(s.s.get(), form.c_str(), &c.c, &err);
    }
    check(status, err);
    return c.text();
}

/* What plot.py makes of what a person says. */
struct plotting {
    std::string form;
    text title, channel, parameter;
    std::vector<double> incidence;
    ff_plot_options o;
    explicit plotting(const py::dict &d)
    {
        ff_plot_options_init(&o);
        form = py::cast<std::string>(d["form"]);
        title = py::cast<text>(d["title"]);
        channel = py::cast<text>(d["channel"]);
        parameter = py::cast<text>(d["parameter"]);
        incidence = py::cast<std::vector<double>>(d["incidence"]);
        o.form = form.c_str();
        o.title = title ? title->c_str() : nullptr;
        o.channel = channel ? channel->c_str() : nullptr;
        o.parameter = parameter ? parameter->c_str() : nullptr;
        o.incidence = incidence.data();
        o.n_incidence = incidence.size();
        o.log = py::cast<int>(d["log"]);
        o.repeats = py::cast<size_t>(d["repeats"]);
        o.seed = py::cast<uint64_t>(d["seed"]);
        o.width = py::cast<double>(d["width"]);
        o.height = py::cast<double>(d["height"]);
        o.font = py::cast<double>(d["font"]);
        o.per_row = py::cast<size_t>(d["per_row"]);
    }
};

py::bytes plot_study(study &s, const std::string &kind, const py::dict &d)
{
    const plotting p(d);
    content c;
    ff_error err = {};
    ff_status status = FF_OK;
    const turn mine(s);
    s.asked_of_fits.ears.work([&] { status = ff_study_plot(s.s.get(), kind.c_str(), &p.o, &c.c, &err); }, py::none());
    check(status, err);
    return c.bytes();
}

py::bytes plot_table(const table &t, const std::string &kind, const py::dict &d)
{
    const plotting p(d);
    content c;
    ff_error err = {};
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = ff_table_plot(t.t.get(), kind.c_str(), &p.o, &c.c, &err);
    }
    check(status, err);
    return c.bytes();
}

py::bytes plot_models(const std::vector<std::shared_ptr<model>> &models, const std::vector<std::string> &labels,
                      const std::string &kind, const py::dict &d)
{
    const plotting p(d);
    std::vector<ff_plotted> all;
    for (size_t k = 0; k < models.size(); k++) {
        const values &v = models[k]->own;
        all.push_back({labels.at(k).c_str(), models[k]->m.get(), v.channels, v.shape.data(), v.channel.data()});
    }
    content c;
    ff_error err = {};
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = ff_models_plot(all.data(), all.size(), kind.c_str(), &p.o, &c.c, &err);
    }
    check(status, err);
    return c.bytes();
}

/* (what would be in the file, or None where there is a path; JSON about it) */
py::tuple write_export(study &s, size_t i, const std::string &to, const text &path)
{
    content file, about;
    ff_error err = {};
    ff_status status = FF_OK;
    const turn mine(s);
    s.asked_of_fits.ears.work(
        [&] {
            status =
                ff_study_export(s.s.get(), i, to.c_str(), path ? path->c_str() : nullptr, path ? nullptr : &file.c, &about.c, &err);
        },
        py::none());
    check(status, err);
    return py::make_tuple(path ? py::object(py::none()) : py::object(file.bytes()), about.text());
}

py::list notes_of(const study &s)
{
    py::list all;
    const char *note;
    for (size_t k = 0; (note = ff_study_note(s.s.get(), k)) != nullptr; k++) all.append(note);
    return all;
}
} // namespace

void add_studies(py::module_ &m)
{
    py::class_<study, std::shared_ptr<study>> c(m, "Study");
    c.def(py::init(&new_study), py::arg("measured"), py::arg("models"), py::arg("options"), py::arg("progress"));
    c.def_property_readonly("fits", [](const study &s) { return ff_study_fit_count(s.s.get()); });
    c.def_property_readonly("problems", [](const study &s) { return ff_study_problem_count(s.s.get()); });
    c.def_property_readonly("notes", notes_of);
    c.def_property_readonly("measured", [](const study &s) { return s.measured; });
    c.def_property_readonly("loss", [](const study &s) { return ff_loss_name((int)ff_study_fit_options(s.s.get())->loss); });
    c.def(
        "ranked",
        [](const study &s, size_t problem, size_t rank) { return (py::ssize_t)ff_study_ranked(s.s.get(), problem, rank); },
        py::arg("problem"), py::arg("rank"));
    c.def(
        "outcome", [](const study &s, size_t i) { return ff_outcome_name((int)ff_fit_result_outcome(fit_of(s, i))); },
        py::arg("fit"));
    c.def(
        "shape", [](const study &s, size_t i) { return ff_shape_name((int)ff_fit_result_shape(fit_of(s, i))); }, py::arg("fit"));
    c.def("channels", channels_of, py::arg("fit"));
    c.def("values", values_of, py::arg("fit"));
    c.def("covariance", covariance_of, py::arg("fit"));
    c.def("warnings", warnings_of, py::arg("fit"));
    c.def("numbers", numbers_of, py::arg("fit"));
    c.def("versus", versus_of, py::arg("fit"));
    c.def("residuals", residuals_of, py::arg("fit"));
    c.def("selection", selection_of, py::arg("fit"));
    c.def("noise", noise_of, py::arg("fit"));
    c.def("model", model_of, py::arg("fit"));
    c.def("write", write, py::arg("form"));
    c.def("plot", plot_study, py::arg("kind"), py::arg("options"));
    c.def("export", write_export, py::arg("fit"), py::arg("to"), py::arg("path"));
    m.def("plot_table", plot_table, py::arg("table"), py::arg("kind"), py::arg("options"));
    m.def("plot_models", plot_models, py::arg("models"), py::arg("labels"), py::arg("kind"), py::arg("options"));
}
} // namespace bind
