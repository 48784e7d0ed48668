/* A distribution without a formula: retrieved, and looked at. */
#include "model.h"
#include "options.h"
#include "table.h"
#include <cmath>
#include "ff_ndf.h"
#include "ff_words.h"

namespace bind
{
namespace
{
using problem_ptr = std::unique_ptr<ff_problem, releaser<ff_problem, ff_problem_free>>;
using result_ptr = std::unique_ptr<ff_ndf_result, releaser<ff_ndf_result, ff_ndf_result_free>>;

struct retrieval {
    explicit retrieval(const py::dict &o) : asked(o)
    {
    }
    py::object measured; /* keeps the table */
    asking asked;
    ff_ndf_options options;
    problem_ptr problem;
    result_ptr result;
};

int masking_of(const std::string &word)
{
    ff_error err = {};
    const int k = ff_term_find(FF_MASKING, word.c_str());
    if (k < 0)
        check(ff_error_set(&err, FF_ERR_UNKNOWN, nullptr, 0, -1, "unknown masking '%.40s'; models() lists them", word.c_str()),
              err);
    return k;
}

std::shared_ptr<retrieval> new_retrieval(const py::object &measured, const py::dict &o, const py::object &progress)
{
    auto r = std::make_shared<retrieval>(o);
    r->measured = measured;
    ff_ndf_options_init(&r->options);
    r->options.fit = &r->asked.fit;
    r->options.masking = masking_of(py::cast<std::string>(o["masking"]));
    r->options.smooth = py::cast<double>(o["smooth"]);
    r->options.monotone = (ff_ndf_monotone)found(o, "monotone", ff_ndf_monotone_find, ff_ndf_monotone_name);
    r->options.nodes = py::cast<int>(o["nodes"]);
    const ff_table *t = measured.cast<table &>().t.get();
    ff_problem *p = nullptr;
    ff_ndf_result *found = nullptr;
    ff_error err = {};
    ff_status status = FF_OK;
    r->asked.ears.work(
        [&] {
            status = ff_ndf_problem_new(t, &r->options, &p, &err);
            if (!status) status = ff_ndf_retrieve(p, &r->options, &found, &err);
        },
        progress);
    r->problem.reset(p);
    r->result.reset(found);
    check(status, err);
    return r;
}

/* theta, D, relative errors of F0 D and of D, is it known: of every row. */
py::tuple rows_of(const retrieval &r)
{
    const size_t n = ff_ndf_result_row_count(r.result.get());
    std::vector<double> theta(n), d(n), error(n), d_error(n);
    py::array_t<bool> known((py::ssize_t)n);
    for (size_t k = 0; k < n; k++) {
        const ff_ndf_row *row = ff_ndf_result_row(r.result.get(), k);
        theta[k] = row->theta;
        d[k] = row->d;
        error[k] = row->error;
        d_error[k] = row->d_error;
        known.mutable_data()[k] = row->known != 0;
    }
    return py::make_tuple(copied(theta.data(), n), copied(d.data(), n), copied(error.data(), n), copied(d_error.data(), n), known);
}

/* (name, f0, ks, kd, error of f0 or of ks, error of kd) of every channel */
py::list channels_of(const retrieval &r)
{
    py::list all;
    for (size_t c = 0; c < ff_ndf_result_channel_count(r.result.get()); c++) {
        const ff_ndf_channel *v = ff_ndf_result_channel(r.result.get(), c);
        all.append(py::make_tuple(ff_problem_channel_name(r.problem.get(), c), v->f0, v->ks, v->kd, v->scale_error, v->kd_error));
    }
    return all;
}

py::dict numbers_of(const retrieval &r)
{
    const ff_ndf_result *of = r.result.get();
    const ff_ndf_measures *m = ff_ndf_result_measures(of);
    py::dict d;
    d["half_width"] = m->half_width;
    d["mean_slope"] = m->mean_slope;
    d["rms_slope"] = m->rms_slope;
    d["beyond"] = m->beyond;
    d["alpha_peak"] = m->alpha_peak;
    d["beckmann_mean"] = m->beckmann_mean;
    d["ggx_mean"] = m->ggx_mean;
    d["first"] = ff_ndf_result_first(of);
    d["reach"] = ff_ndf_result_reach(of);
    d["sure"] = ff_ndf_result_sure(of);
    d["smooth"] = ff_ndf_result_smooth(of);
    d["effective"] = ff_ndf_result_effective(of);
    d["objective"] = ff_ndf_result_objective(of);
    d["seconds"] = ff_ndf_result_seconds(of);
    return d;
}

/* The models that went with it, with what was found: beckmann, ggx, student-t, and that of the table, which lives as long as the
 * model does; the one of the result may not. */
std::shared_ptr<model> model_of(const retrieval &r, int which, const std::shared_ptr<profile> &table)
{
    const ff_fit_result *fit = ff_ndf_result_fit(r.result.get(), which);
    if (!fit) throw py::index_error("there is no such fit");
    auto made = copy_model(ff_fit_result_model(fit), which == FF_NDF_TABULATED ? table : nullptr);
    if (made->table) ff_model_set_table(made->m.get(), made->table->t.get());
    made->own = found_values(fit);
    return made;
}

double objective_of(const retrieval &r, int which)
{
    const ff_fit_result *fit = ff_ndf_result_fit(r.result.get(), which);
    if (!fit) throw py::index_error("there is no such fit");
    return ff_fit_result_objective(fit);
}

/* (code, severity, sentence, {name: value}) */
py::list warnings_of(const retrieval &r)
{
    py::list all;
    for (size_t k = 0; k < ff_ndf_result_warning_count(r.result.get()); k++) {
        const ff_warning *w = ff_ndf_result_warning(r.result.get(), k);
        const ff_warning_kind *kind = ff_warning_kind_of((int)w->code);
        py::dict numbers;
        for (size_t j = 0; j < FF_WARNING_VALUES && kind->value[j]; j++) numbers[kind->value[j]] = w->value[j];
        std::string sentence(ff_words_ndf_warning(r.problem.get(), r.result.get(), w, nullptr, 0) + 1, '\0');
        ff_words_ndf_warning(r.problem.get(), r.result.get(), w, &sentence[0], sentence.size());
        sentence.pop_back();
        all.append(py::make_tuple(kind->name, ff_severity_name((int)w->severity), sentence, numbers));
    }
    return all;
}
} // namespace

void add_retrievals(py::module_ &m)
{
    py::class_<retrieval, std::shared_ptr<retrieval>> c(m, "Retrieval");
    c.def(py::init(&new_retrieval), py::arg("measured"), py::arg("options"), py::arg("progress"));
    c.def_property_readonly("rows", rows_of);
    c.def_property_readonly("channels", channels_of);
    c.def_property_readonly("numbers", numbers_of);
    c.def_property_readonly("warnings", warnings_of);
    c.def_property_readonly("outcome",
                            [](const retrieval &r) { return ff_outcome_name((int)ff_ndf_result_outcome(r.result.get())); });
    c.def_property_readonly("is_scaled", [](const retrieval &r) { return ff_ndf_result_is_scaled(r.result.get()) != 0; });
    c.def_property_readonly("from_back_scatter",
                            [](const retrieval &r) { return ff_ndf_result_from_back_scatter(r.result.get()) != 0; });
    c.def("model", model_of, py::arg("which"), py::arg("table"));
    c.def("objective", objective_of, py::arg("which"));
}
} // namespace bind
