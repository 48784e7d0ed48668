/** The baseline of the solver benchmark: the program a user of Ceres would write for this fit. One AutoDiffCostFunction with
 *  one residual per sample, one parameter block, one thread, the solver's defaults for everything but the linear solver.
 *
 *      bench_plain_ceres DENSE_QR|DENSE_NORMAL_CHOLESKY [converged]
 *
 *  `converged` goes on where the default tolerances stop (a relative change of the cost below 1e-6): to the optimum itself, for
 *  comparing optima, not times.
 *  Prints one JSON object. Times are of ceres::Solve alone (solve_s) and with building the problem (total_s); peak_rss_mb is of
 *  the whole process, base_rss_mb of it with the samples alone. */
#include "ggx_samples.h"
#include <ceres/ceres.h>
#include <cstdio>
#include <cstring>
#include <sys/resource.h>
#include <time.h>
#include <vector>

namespace
{

class GgxResidual
{
  public:
    explicit GgxResidual(const Sample &s) : wi_(direction(s.theta_i, s.phi_i)), wo_(direction(s.theta_o, s.phi_o)), value_(s.value)
    {
    }
    template <typename T>
    bool operator()(const T *p, T *residual) const
    {
        residual[0] = (ggx(p, wi_, wo_) - value_) * wi_.z;
        return true;
    }

  private:
    Vec3 wi_, wo_;
    double value_;
};

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

} // namespace

int main(int argc, char **argv)
{
    ceres::Solver::Options options;
    options.logging_type = ceres::SILENT;
    const bool converged = argc == 3 && std::strcmp(argv[2], "converged") == 0;
    if (argc != 2 + converged || !ceres::StringToLinearSolverType(argv[1], &options.linear_solver_type)) {
        std::fprintf(stderr, "usage: %s DENSE_QR|DENSE_NORMAL_CHOLESKY [converged]\n", argv[0]);
        return 2;
    }
    if (converged) options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-14;
    std::vector<Sample> samples(kSamples);
    SampleSource source(kTruth[F0]);
    for (Sample &s : samples) s = source.next();
    const double base_rss = peak_rss_mb(), begin = now();
    double p[N_PARAMS] = {kStart[0], kStart[1], kStart[2], kStart[3]};
    ceres::Problem problem;
    for (const Sample &s : samples) {
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<GgxResidual, 1, N_PARAMS>(new GgxResidual(s)), nullptr, p);
    }
    const double built = now();
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    const double end = now();
    std::printf("{\"linear_solver\": \"%s\", \"samples\": %zu, \"solve_s\": %.6f, \"total_s\": %.6f, \"iterations\": %zu, "
                "\"outcome\": \"%s\", \"cost\": %.17g, \"parameters\": [%.17g, %.17g, %.17g, %.17g], \"base_rss_mb\": %.1f, "
                "\"peak_rss_mb\": %.1f}\n",
                ceres::LinearSolverTypeToString(options.linear_solver_type), samples.size(), end - built, end - begin,
                summary.iterations.size() - 1, summary.termination_type == ceres::CONVERGENCE ? "converged" : "limit",
                summary.final_cost, p[0], p[1], p[2], p[3], base_rss, peak_rss_mb());
    return 0;
}
