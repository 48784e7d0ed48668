/** The solver benchmark on the library's side: the samples of ggx_samples.h through ff_problem_new and ff_problem_fit.
 *
 *      bench_solve given|search|errors|threads REPEATS
 *
 *  given    one thread, from the start of the plain Ceres program, without standard errors: what that program does
 *  search   the same with the library's own search for a start
 *  errors   the same as given, with standard errors
 *  threads  three channels, one thread and two by turns, from the same start
 *
 *  Every repeat makes a new problem, so that nothing is warm but the caches of the processor. Prints one JSON object. */
#include "fit/interface/fit_struct.h"
#include "models/model_struct.h"
#include "data_formats/table/table_struct.h"
#include "ggx_samples.h"
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <sys/resource.h>
#include <time.h>

namespace
{

double now()
{
    timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double peak_rss_mb()
{
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) * 1024e-6;
}

void require(ff_status status, const ff_error &error, const char *what)
{
    char message[1024];
    if (status == FF_OK) return;
    ff_error_format(&error, message, sizeof message);
    std::fprintf(stderr, "bench_solve: %s: %s: %s\n", what, ff_status_str(status), message);
    std::exit(1);
}

/** The channels share directions and noise and differ in F0. */
ff_table make_table(std::size_t n_channels)
{
    const double f0[3] = {kTruth[F0], 0.6, 0.3};
    ff_table t = {};
    ff_error error = {};
    require(ff_table_init(kSamples, n_channels, nullptr, 0, 0, &t, &error), error, "table");
    t.radians_per_unit = M_PI / 180;
    for (std::size_t c = 0; c < n_channels; c++) {
        SampleSource source(f0[c]);
        for (std::size_t i = 0; i < kSamples; i++) {
            const Sample s = source.next();
            t.angle[0][i] = s.theta_i;
            t.angle[1][i] = s.phi_i;
            t.angle[2][i] = s.theta_o;
            t.angle[3][i] = s.phi_o;
            t.value[c * kSamples + i] = s.value;
        }
    }
    return t;
}

struct Start {
    double shape[FF_MAX_SHAPE], channel[3 * FF_MAX_CHANNEL_PARAMS];
};

Start make_start(const ff_model &m, std::size_t n_channels)
{
    Start start;
    ff_error error = {};
    ff_model_defaults(&m, n_channels, start.shape, start.channel);
    const char *const names[N_PARAMS] = {"alpha_x", "alpha_y", "r_xy", "f0"};
    for (int k = 0; k < N_PARAMS; k++) {
        const std::string assignment = std::string(names[k]) + "=" + std::to_string(kStart[k]);
        require(ff_model_set(&m, n_channels, assignment.c_str(), start.shape, start.channel, &error), error, names[k]);
    }
    return start;
}

double parameter(const ff_fit_result &fit, const char *name)
{
    return ff_fit_result_find(&fit, name, 0)->value;
}

/** One repeat: a new problem and a fit; prints its object. */
void run(const ff_table &t, const ff_model &m, const ff_fit_options &o)
{
    ff_error error = {};
    ff_problem *problem = nullptr;
    ff_fit_result fit;
    const double begin = now();
    require(ff_problem_make(&t, &m, 1, &o, &problem, &error), error, "problem");
    const double made = now();
    require(ff_problem_fit_into(problem, &m, &o, &fit, &error), error, "fit");
    const double end = now();
    std::printf("{\"threads\": %d, \"problem_s\": %.6f, \"solve_s\": %.6f, \"iterations\": %d, \"passes\": %d, \"outcome\": "
                "\"%s\", \"cost\": "
                "%.17g, \"parameters\": [%.17g, %.17g, %.17g, %.17g]}",
                o.threads, made - begin, end - made, fit.iterations, fit.passes, ff_outcome_name(fit.outcome),
                fit.residual.objective, parameter(fit, "alpha_x"), parameter(fit, "alpha_y"), parameter(fit, "r_xy"),
                parameter(fit, "f0"));
    ff_fit_result_clear(&fit);
    ff_problem_free(problem);
}

} // namespace

int main(int argc, char **argv)
{
    const std::string mode = argc == 3 ? argv[1] : "";
    const int repeats = argc == 3 ? std::atoi(argv[2]) : 0;
    if ((mode != "given" && mode != "search" && mode != "errors" && mode != "threads") || repeats < 1) {
        std::fprintf(stderr, "usage: %s given|search|errors|threads REPEATS\n", argv[0]);
        return 2;
    }
    const std::size_t n_channels = mode == "threads" ? 3 : 1;
    ff_error error = {};
    ff_model model;
    require(ff_model_parse("ggx", &model, &error), error, "model");
    const Start start = make_start(model, n_channels);
    ff_table table = make_table(n_channels);

    ff_fit_options o;
    ff_fit_options_init(&o);
    o.loss = FF_LOSS_COSINE;
    o.weighting = FF_WEIGHT_SAMPLE;
    o.shape = FF_SHAPE_CORRELATED;
    o.max_theta = M_PI / 2;
    o.std_errors = mode == "errors";
    if (mode != "search") {
        o.start_shape = start.shape;
        o.start_channel = start.channel;
    }
    std::printf("{\"mode\": \"%s\", \"samples\": %zu, \"channels\": %zu, \"base_rss_mb\": %.1f, \"runs\": [", mode.c_str(),
                kSamples, n_channels, peak_rss_mb());
    for (int i = 0; i < repeats; i++) {
        for (o.threads = 1; o.threads <= (mode == "threads" ? 2 : 1); o.threads++) {
            if (i > 0 || o.threads > 1) std::printf(", ");
            run(table, model, o);
        }
    }
    std::printf("], \"peak_rss_mb\": %.1f}\n", peak_rss_mb());
    ff_table_clear(&table);
    return 0;
}
