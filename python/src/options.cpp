#include "options.h"

namespace bind
{
asking::asking(const py::dict &o)
{
    take_constraints(o);
    take_fit(o);
}

const char *asking::keep(const std::string &word)
{
    words.push_back(word);
    return words.back().c_str();
}

const char *asking::keep_channel(const py::handle &channel)
{
    return channel.is_none() ? nullptr : keep(py::cast<std::string>(channel));
}

/* (name, lo, hi, channel) ... as fit.py makes them of what a person says. */
void asking::take_constraints(const py::dict &o)
{
    for (const auto &one : py::cast<py::list>(o["bounds"])) {
        const auto b = py::cast<py::tuple>(one);
        bound.push_back({keep(py::cast<std::string>(b[0])), py::cast<double>(b[1]), py::cast<double>(b[2]), keep_channel(b[3])});
    }
    for (const auto &one : py::cast<py::list>(o["priors"])) {
        const auto p = py::cast<py::tuple>(one);
        prior.push_back({keep(py::cast<std::string>(p[0])), py::cast<double>(p[1]), py::cast<double>(p[2]), keep_channel(p[3])});
    }
    for (const auto &one : py::cast<py::list>(o["ties"])) {
        const auto t = py::cast<py::tuple>(one);
        tie.push_back({keep(py::cast<std::string>(t[0])), keep_channel(t[1])});
    }
    for (const auto &one : py::cast<py::list>(o["fixed"])) {
        const auto f = py::cast<py::tuple>(one);
        lists.push_back(py::cast<std::vector<double>>(f[1]));
        fixed.push_back({keep(py::cast<std::string>(f[0])), lists.back().size(), lists.back().data(), keep_channel(f[2])});
    }
    constraints.n_bounds = bound.size();
    constraints.n_priors = prior.size();
    constraints.n_ties = tie.size();
    constraints.n_fixed = fixed.size();
    constraints.bound = bound.data();
    constraints.prior = prior.data();
    constraints.tie = tie.data();
    constraints.fixed = fixed.data();
    constraints.energy_conserving = py::cast<bool>(o["energy_conserving"]);
    constraints.where_present = py::cast<bool>(o["where_present"]);
}

/* The number of a word; what is known is said by the library's list. */
int found(const py::dict &o, const char *key, int (*find)(const char *), const char *(*name)(int))
{
    const std::string word = py::cast<std::string>(o[key]);
    const int k = find(word.c_str());
    std::string known;
    ff_error err = {};
    if (k >= 0) return k;
    for (int i = 0; name(i); i++) known += (i ? ", " : "") + std::string(name(i));
    check(ff_error_set(&err, FF_ERR_UNKNOWN, nullptr, 0, -1, "%s '%.40s'; known are %s", key, word.c_str(), known.c_str()), err);
    return 0;
}

void asking::take_fit(const py::dict &o)
{
    ff_fit_options &f = fit;
    ff_fit_options_init(&f);
    f.loss = (ff_loss)found(o, "loss", ff_loss_find, ff_loss_name);
    f.robust = (ff_robust)found(o, "robust", ff_robust_find, ff_robust_name);
    f.robust_scale = py::cast<double>(o["robust_scale"]);
    f.weighting = (ff_weighting)found(o, "weight", ff_weighting_find, ff_weighting_name);
    f.shape = (ff_shape)found(o, "shape", ff_shape_find, ff_shape_name);
    f.channels = (ff_channel_mode)found(o, "channels", ff_channel_mode_find, ff_channel_mode_name);
    f.errors = (ff_error_source)found(o, "errors", ff_error_source_find, ff_error_source_name);
    f.max_theta = py::cast<double>(o["max_theta"]);
    f.saturation = py::cast<double>(o["saturation"]);
    f.noise_floor = py::cast<double>(o["noise_floor"]);
    f.noise_sigmas = py::cast<double>(o["noise_sigmas"]);
    f.drop_negative = py::cast<bool>(o["drop_negative"]);
    f.mean_slope = py::cast<bool>(o["mean_slope"]);
    f.threads = py::cast<int>(o["threads"]);
    f.max_iterations = py::cast<int>(o["max_iterations"]);
    of = py::cast<std::shared_ptr<noise>>(o["noise"]);
    f.noise = of ? of->n.get() : nullptr;
    if (!o["aperture"].is_none()) {
        const std::string words = py::cast<std::string>(o["aperture"]);
        ff_error err = {};
        const ff_status status = ff_aperture_parse(words.c_str(), &aperture);
        if (status)
            ff_error_set(&err, status, nullptr, 0, -1,
                         "aperture '%.40s': expected half angles in degrees, as 0.75, 0.75:square or 0.5x1", words.c_str());
        check(status, err);
    }
    aperture.source = py::cast<double>(o["source"]);
    f.aperture = &aperture;
    f.constraints = &constraints;
    f.cancel = &ears.cancel;
    f.progress = ear::hear_progress;
    f.progress_context = &ears;
}
} // namespace bind
