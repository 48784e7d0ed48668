// path_sampler: what a path tracer takes of the library: directions drawn in proportion to a model, their weights, and the density
// that multiple importance sampling asks for. Prints the albedo by samples beside the one by quadrature.
#include <facetfit/ff_albedo.h>
#include <facetfit/ff_sample.h>
#include <facetfit/ff_simulate.h>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <vector>

// Objects of the library release themselves.
using model_ptr = std::unique_ptr<ff_model, decltype(&ff_model_free)>;
using sampler_ptr = std::unique_ptr<ff_sampler, decltype(&ff_sampler_free)>;

static void check(ff_status status, const ff_error &err)
{
    if (status) throw std::runtime_error(err.message[0] ? err.message : ff_status_str(status));
}

static int run()
{
    enum { PATHS = 100000 };
    ff_error err = {};
    ff_model *m = nullptr;
    check(ff_model_new("ggx+lambert", &m, &err), err);
    const model_ptr model(m, ff_model_free);
    std::vector<double> shape(ff_model_param_count(m, FF_PARAM_SHAPE)), channel(ff_model_param_count(m, FF_PARAM_CHANNEL));
    ff_model_defaults(m, 1, shape.data(), channel.data());
    for (const char *said : {"alpha=0.3", "f0=0.8", "kd=0.1"}) check(ff_model_set(m, 1, said, shape.data(), channel.data(), &err), err);
    ff_sampler *s = nullptr;
    check(ff_sampler_new(m, FF_ISA_BEST, 1, shape.data(), channel.data(), &s, &err), err);
    const sampler_ptr sampler(s, ff_sampler_free);

    const double view[3] = {std::sin(0.7), 0, std::cos(0.7)};
    double sum = 0, squares = 0, mismatch = 0;
    for (uint64_t k = 0; k < PATHS; k++) { // one at a time, as a renderer does; blocks are faster
        const double u[3] = {ff_random_uniform(1, 0, k), ff_random_uniform(1, 1, k), ff_random_uniform(1, 2, k)};
        double wi[3], pdf, f, weight, again;
        ff_sampler_sample(s, 1, view, u, nullptr, wi, &pdf, &f, &weight, 1);
        ff_sampler_pdf(s, 1, view, wi, &again, 1);
        mismatch = std::fmax(mismatch, std::fabs(again - pdf));
        sum += weight;
        squares += weight * weight;
    }
    ff_integral albedo;
    check(ff_albedo_directional(m, FF_ISA_BEST, 1, shape.data(), channel.data(), view, &albedo, &err), err);
    const double mean = sum / PATHS, error = std::sqrt((squares / PATHS - mean * mean) / PATHS);
    std::printf("albedo by samples %.5f +- %.5f, by quadrature %.5f +- %.0e\n", mean, error, albedo.value, albedo.error);
    return std::fabs(mean - albedo.value) < 5 * error && mismatch < 1e-9 ? 0 : 1;
}

int main()
try {
    return run();
} catch (const std::exception &e) {
    std::fprintf(stderr, "path_sampler: %s\n", e.what());
    return 1;
}
