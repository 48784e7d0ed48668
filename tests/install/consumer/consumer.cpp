// A program in C++ that has nothing but the installed headers and libraries, whose closed types go well with smart pointers.
#include <facetfit/ff_fit.h>
#include <facetfit/ff_simulate.h>
#include <facetfit/ff_trust.h>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

namespace
{

template <auto Free>
struct Releases {
    template <typename T>
    void operator()(T *p) const
    {
        Free(p);
    }
};
using Model = std::unique_ptr<ff_model, Releases<ff_model_free>>;
using Table = std::unique_ptr<ff_table, Releases<ff_table_free>>;
using Problem = std::unique_ptr<ff_problem, Releases<ff_problem_free>>;
using Result = std::unique_ptr<ff_fit_result, Releases<ff_fit_result_free>>;

ff_error error;

/** What a call has made, in the hands of somebody who releases it; empty when it failed. */
template <typename Owner, typename Call>
Owner made(const char *what, Call call)
{
    typename Owner::pointer p = nullptr;
    if (call(&p) != FF_OK) std::fprintf(stderr, "%s: %s\n", what, error.message);
    return Owner(p);
}

bool run()
{
    const Model model = made<Model>("model", [](ff_model **out) { return ff_model_new("beckmann+lambert", out, &error); });
    if (!model) return false;
    std::vector<double> shape(ff_model_param_count(model.get(), FF_PARAM_SHAPE));
    std::vector<double> channel(3 * ff_model_param_count(model.get(), FF_PARAM_CHANNEL));
    ff_model_defaults(model.get(), 3, shape.data(), channel.data());
    for (const char *assignment : {"alpha=0.25", "f0=0.9:0.6:0.3", "kd=0.1:0.2:0.3"})
        if (ff_model_set(model.get(), 3, assignment, shape.data(), channel.data(), &error) != FF_OK) return false;
    ff_simulate_options how;
    ff_simulate_options_init(&how);
    const Table table = made<Table>(
        "data", [&](ff_table **out) { return ff_simulate(model.get(), 3, shape.data(), channel.data(), &how, out, &error); });
    ff_fit_options o;
    ff_fit_options_init(&o);
    o.threads = 1;
    const ff_model *models[] = {model.get()};
    const Problem problem =
        made<Problem>("problem", [&](ff_problem **out) { return ff_problem_new(table.get(), models, 1, &o, out, &error); });
    if (!problem) return false;
    const Result fit =
        made<Result>("fit", [&](ff_fit_result **out) { return ff_problem_fit(problem.get(), model.get(), &o, out, &error); });
    if (!fit) return false;
    std::vector<double> found(channel.size());
    ff_fit_result_values(fit.get(), nullptr, found.data());
    double worst = 0;
    for (std::size_t k = 0; k < found.size(); k++) worst = std::fmax(worst, std::fabs(found[k] - channel[k]));
    std::printf("C++: %zu numbers of three channels, no further than %.1e from the truth\n", found.size(), worst);
    return ff_fit_result_outcome(fit.get()) == FF_CONVERGED && worst < 1e-4;
}

} // namespace

int main()
{
    return run() ? 0 : 1;
}
