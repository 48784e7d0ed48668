#include "ceres_bridge.h"

#include <cmath>
#include <exception>
#include <vector>

#include <ceres/ceres.h>

namespace
{

/// The caller's compressed residuals as one cost function of one parameter block.
class CompressedCost final : public ceres::CostFunction
{
  public:
    explicit CompressedCost(const ff_ceres_problem &problem) : problem_(problem)
    {
        set_num_residuals(static_cast<int>(problem.n) + 1);
        mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.n));
    }

    bool Evaluate(double const *const *parameters, double *residuals, double **jacobians) const override
    {
        double *jacobian = jacobians != nullptr ? jacobians[0] : nullptr;
        return problem_.evaluate(problem_.context, parameters[0], residuals, jacobian) == FF_OK;
    }

  private:
    const ff_ceres_problem &problem_;
};

class Iterated final : public ceres::IterationCallback
{
  public:
    explicit Iterated(const ff_ceres_problem &problem) : problem_(problem)
    {
    }

    ceres::CallbackReturnType operator()(const ceres::IterationSummary &summary) override
    {
        const int answer = problem_.iterated(problem_.context, summary.iteration, summary.cost);
        if (answer < 0) return ceres::SOLVER_ABORT;
        return answer > 0 ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
    }

  private:
    const ff_ceres_problem &problem_;
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
    CompressedCost cost(p);
    Iterated iterated(p);
    ceres::Problem::Options ownership;
    ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(ownership);
    std::vector<double> at(x, x + p.n);
    problem.AddResidualBlock(&cost, nullptr, at.data());
    for (size_t i = 0; i < p.n; i++) {
        if (std::isfinite(p.lower[i])) problem.SetParameterLowerBound(at.data(), static_cast<int>(i), p.lower[i]);
        if (std::isfinite(p.upper[i])) problem.SetParameterUpperBound(at.data(), static_cast<int>(i), p.upper[i]);
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
    out->cost = summary.final_cost;
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
    for (size_t i = 0; i < p.n; i++) x[i] = at[i];
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
