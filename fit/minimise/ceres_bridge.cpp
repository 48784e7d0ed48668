#include "ceres_bridge.h"

#include <cmath>
#include <exception>
#include <limits>
#include <vector>

#include <ceres/ceres.h>
#include <ceres/version.h>

namespace
{

/// The power of two next below v: multiplying by it rounds nothing, so that a point comes back as it was given.
double PowerOfTwo(double v)
{
    return v > 0 && std::isfinite(v) ? std::ldexp(1.0, std::ilogb(v)) : 1;
}

/// What the residual and the parameters are measured in. Ceres has constants of its own (a 1 that is added to the lengths of
/// columns, the least diagonal of its damping, one norm over all parameters), so it gets a problem without units: at the start the
/// residual has a length near 1 and every column of its Jacobian one near COLUMN, long against those constants as with many
/// samples. No unit is larger than the parameter itself or 1, what a roughness, a reflectance or a logarithm is measured in: a
/// parameter that moves little at a bad start (eta in a conductor's valley) would take steps over its whole range.
constexpr double COLUMN = 1024;
/// A column that is shorter than this beside the residual moves nothing, and its parameter keeps its unit.
constexpr double LEAST = 1e-20;

struct Units {
    double residual = 1;
    std::vector<double> parameter;

    Units(const ff_ceres_problem &p, const double *x) : parameter(p.n, 1)
    {
        std::vector<double> r(p.n + 1), jacobian((p.n + 1) * p.n);
        if (p.evaluate(p.context, x, r.data(), jacobian.data()) != FF_OK) return;
        residual = PowerOfTwo(Length(r.data(), p.n + 1, 1));
        for (size_t k = 0; k < p.n; k++) {
            const double column = Length(&jacobian[k], p.n + 1, p.n), most = PowerOfTwo(std::fmax(1, std::fabs(x[k])));
            if (column > residual * LEAST) parameter[k] = std::fmin(COLUMN * PowerOfTwo(residual / column), most);
        }
    }

    static double Length(const double *v, size_t n, size_t stride)
    {
        double sum = 0;
        for (size_t i = 0; i < n; i++) sum += v[i * stride] * v[i * stride];
        return std::sqrt(sum);
    }

    /// Of a point that was refused it is the largest number there is, in any unit.
    double Cost(double cost) const
    {
        return std::fmin(cost * residual * residual, std::numeric_limits<double>::max());
    }
};

/// The caller's compressed residuals as one cost function of one parameter block.
class CompressedCost final : public ceres::CostFunction
{
  public:
    CompressedCost(const ff_ceres_problem &problem, const Units &units) : problem_(problem), units_(units)
    {
        set_num_residuals(static_cast<int>(problem.n) + 1);
        mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.n));
    }

    bool Evaluate(double const *const *parameters, double *residuals, double **jacobians) const override
    {
        double *jacobian = jacobians != nullptr ? jacobians[0] : nullptr;
        const size_t n = problem_.n;
        std::vector<double> x(n);
        for (size_t k = 0; k < n; k++) x[k] = parameters[0][k] * units_.parameter[k];
        if (problem_.evaluate(problem_.context, x.data(), residuals, jacobian) != FF_OK) return false;
        for (size_t i = 0; i <= n; i++) {
            residuals[i] /= units_.residual;
            for (size_t k = 0; k < n && jacobian != nullptr; k++) jacobian[i * n + k] *= units_.parameter[k] / units_.residual;
        }
        return true;
    }

  private:
    const ff_ceres_problem &problem_;
    const Units &units_;
};

class Iterated final : public ceres::IterationCallback
{
  public:
    Iterated(const ff_ceres_problem &problem, const Units &units) : problem_(problem), units_(units)
    {
    }

    ceres::CallbackReturnType operator()(const ceres::IterationSummary &summary) override
    {
        const int answer = problem_.iterated(problem_.context, summary.iteration, units_.Cost(summary.cost));
        if (answer < 0) return ceres::SOLVER_ABORT;
        return answer > 0 ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
    }

  private:
    const ff_ceres_problem &problem_;
    const Units &units_;
};

/// What Ceres would answer with an abort of the process.
bool Acceptable(const ff_ceres_problem &p, const double *x)
{
    if (p.n == 0 || p.n > 100000 || p.evaluate == nullptr || p.max_iterations < 0) return false;
    if (!(p.function_tolerance >= 0) || !(p.gradient_tolerance >= 0) || !(p.parameter_tolerance >= 0)) return false;
    for (size_t i = 0; i < p.n; i++)
        if (!std::isfinite(x[i]) || !(p.lower[i] <= x[i]) || !(x[i] <= p.upper[i])) return false;
    return true;
}

void Solve(const ff_ceres_problem &p, double *x, ff_ceres_summary *out)
{
    const Units units(p, x);
    CompressedCost cost(p, units);
    Iterated iterated(p, units);
    ceres::Problem::Options ownership;
    ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(ownership);
    std::vector<double> at(p.n);
    for (size_t i = 0; i < p.n; i++) at[i] = x[i] / units.parameter[i];
    problem.AddResidualBlock(&cost, nullptr, at.data());
    for (size_t i = 0; i < p.n; i++) {
        if (std::isfinite(p.lower[i]))
            problem.SetParameterLowerBound(at.data(), static_cast<int>(i), p.lower[i] / units.parameter[i]);
        if (std::isfinite(p.upper[i]))
            problem.SetParameterUpperBound(at.data(), static_cast<int>(i), p.upper[i] / units.parameter[i]);
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.num_threads = 1;
    options.max_num_iterations = p.max_iterations;
    options.function_tolerance = p.function_tolerance;
    options.gradient_tolerance = p.gradient_tolerance;
    options.parameter_tolerance = p.parameter_tolerance;
    options.logging_type = ceres::SILENT;
    if (p.iterated != nullptr) options.callbacks.push_back(&iterated);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    out->iterations = static_cast<int>(summary.iterations.size()) - 1;
    out->cost = units.Cost(summary.final_cost);
    switch (summary.termination_type) {
    case ceres::CONVERGENCE:
    case ceres::USER_SUCCESS:
        out->end = FF_CERES_CONVERGED;
        break;
    case ceres::NO_CONVERGENCE:
        out->end = FF_CERES_LIMIT;
        break;
    case ceres::USER_FAILURE:
        out->end = FF_CERES_STOPPED;
        break;
    default:
        out->end = FF_CERES_FAILED;
    }
    for (size_t i = 0; i < p.n; i++) x[i] = at[i] * units.parameter[i];
}

} // namespace

extern "C" ff_status ff_ceres_solve(const ff_ceres_problem *p, double *x, ff_ceres_summary *out, ff_error *err)
{
    try {
        if (!Acceptable(*p, x))
            return ff_error_set(err, FF_ERR_RANGE, nullptr, 0, -1,
                                "the solver was given a start outside its bounds or no parameters");
        Solve(*p, x, out);
        return FF_OK;
    } catch (const std::bad_alloc &) {
        return ff_error_set(err, FF_ERR_MEMORY, nullptr, 0, -1, "out of memory in the solver");
    } catch (const std::exception &e) {
        return ff_error_set(err, FF_ERR_INTERNAL, nullptr, 0, -1, "the solver failed: %s", e.what());
    } catch (...) {
        return ff_error_set(err, FF_ERR_INTERNAL, nullptr, 0, -1, "the solver failed");
    }
}

extern "C" const char *ff_ceres_version(void)
{
    return CERES_VERSION_STRING;
}
