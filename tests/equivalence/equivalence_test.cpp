/* The compressed problem against the plain one: every residual an AutoDiffCostFunction of its own, the model written here once
 * more. At the same point both have the same cost, gradient and Gauss-Newton matrix; from there both reach the same optimum. */
#include "compressed_point.h"
#include "fit_samples.h"
#include <ceres/ceres.h>
#include <vector>

namespace
{

struct Vec3 {
    double x, y, z;
};

enum { SAMPLES = 5000, SHAPE = 3, OPTICS = 2, CHANNELS = 3, P = SHAPE + CHANNELS * OPTICS };

/// alpha_x, alpha_y, r_xy; then f0 and kd of each channel.
struct Parameters {
    double shape[SHAPE];
    double optics[CHANNELS][OPTICS];
};

/// Smith's Lambda of GGX with the projected roughness of w.
template <typename T>
T Lambda(const T *s, const Vec3 &w)
{
    using std::sqrt;
    const T slope2 = (s[0] * s[0] * (w.x * w.x) + s[1] * s[1] * (w.y * w.y) + 2.0 * s[2] * s[0] * s[1] * (w.x * w.y)) / (w.z * w.z);
    return 0.5 * (sqrt(1.0 + slope2) - 1.0);
}

/// D G2 F / (4 iz oz) + kd / pi: correlated GGX, height-correlated Smith, Schlick.
template <typename T>
T Reflectance(const T *s, const T *optics, const Vec3 &i, const Vec3 &o)
{
    using std::sqrt;
    const Vec3 sum = {i.x + o.x, i.y + o.y, i.z + o.z};
    const double length = std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z), hz = sum.z / length;
    const double cosine = (i.x * sum.x + i.y * sum.y + i.z * sum.z) / length, schlick = std::pow(1 - cosine, 5);
    const T u = -sum.x / sum.z / s[0], v = -sum.y / sum.z / s[1], one_r2 = 1.0 - s[2] * s[2];
    const T q = 1.0 + (u * u + v * v - 2.0 * s[2] * u * v) / one_r2;
    const T d = 1.0 / (M_PI * q * q * s[0] * s[1] * sqrt(one_r2) * std::pow(hz, 4));
    const T g = 1.0 / (1.0 + Lambda(s, i) + Lambda(s, o));
    return d * g * (optics[0] + (1.0 - optics[0]) * schlick) / (4.0 * i.z * o.z) + optics[1] / M_PI;
}

class Residual
{
  public:
    Residual(ff_loss loss, double weight, double sigma, const Vec3 &wi, const Vec3 &wo, double y)
        : loss_(loss), scale_(std::sqrt(weight)), sigma_(sigma), wi_(wi), wo_(wo), y_(y)
    {
    }
    template <typename T>
    bool operator()(const T *shape, const T *optics, T *residual) const
    {
        using std::log;
        const T f = Reflectance(shape, optics, wi_, wo_);
        const double x = wi_.z;
        if (sigma_ > 0) /* in standard deviations of g(y) */
            residual[0] = loss_ == FF_LOSS_LOG ? (log(1.0 + f * x) - std::log(1 + y_ * x)) * ((1 + y_ * x) / (x * sigma_))
                                               : (f - y_) / sigma_;
        else
            residual[0] = scale_ * (loss_ == FF_LOSS_LOG ? log(1.0 + f * x) - std::log(1 + y_ * x) : (f - y_) * x);
        return true;
    }

  private:
    ff_loss loss_;
    double scale_, sigma_;
    Vec3 wi_, wo_;
    double y_;
};

/// One comparison.
struct Setting {
    const char *what;
    ff_loss loss;
    ff_robust robust;
    double robust_scale;
    ff_weighting weighting;
};

ceres::LossFunction *RobustLoss(const Setting &s)
{
    if (s.robust == FF_ROBUST_HUBER) return new ceres::HuberLoss(s.robust_scale);
    if (s.robust == FF_ROBUST_CAUCHY) return new ceres::CauchyLoss(s.robust_scale);
    if (s.robust == FF_ROBUST_TUKEY) return new ceres::TukeyLoss(s.robust_scale);
    return nullptr;
}

/// Adds a residual block for every sample and channel of the table.
void AddResiduals(const ff_table &t, const Setting &setting, Parameters *p, ceres::Problem *problem)
{
    std::vector<double> w(6 * t.n), weight(t.n, 1.0);
    double *planes[6], mean = 0;
    for (size_t k = 0; k < 6; k++) planes[k] = &w[k * t.n];
    ff_table_directions(&t, 0, t.n, planes);
    if (setting.weighting == FF_WEIGHT_SOLID_ANGLE) ff_table_weights(&t, 0, t.n, weight.data());
    for (double v : weight) mean += v / static_cast<double>(t.n);
    for (size_t i = 0; i < t.n; i++)
        for (size_t c = 0; c < CHANNELS; c++) {
            const double sigma = setting.weighting == FF_WEIGHT_SIGMA ? t.sigma[c * t.n + i] : 0;
            auto *functor = new Residual(setting.loss, weight[i] / mean, sigma, {planes[0][i], planes[1][i], planes[2][i]},
                                         {planes[3][i], planes[4][i], planes[5][i]}, t.value[c * t.n + i]);
            problem->AddResidualBlock(new ceres::AutoDiffCostFunction<Residual, 1, SHAPE, OPTICS>(functor), RobustLoss(setting),
                                      p->shape, p->optics[c]);
        }
}

/// Cost, gradient and J^T J of the plain problem at its parameters, in the order of Parameters.
struct Point {
    double cost;
    std::vector<double> gradient, gram;
};

Point PlainPoint(ceres::Problem *problem, Parameters *p)
{
    Point out = {0, {}, std::vector<double>(P * P, 0.0)};
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = {p->shape, p->optics[0], p->optics[1], p->optics[2]};
    ceres::CRSMatrix jacobian;
    if (!problem->Evaluate(options, &out.cost, nullptr, &out.gradient, &jacobian)) out.cost = NAN;
    for (int row = 0; row < jacobian.num_rows; row++)
        for (int a = jacobian.rows[row]; a < jacobian.rows[row + 1]; a++)
            for (int b = jacobian.rows[row]; b < jacobian.rows[row + 1]; b++)
                out.gram[static_cast<size_t>(jacobian.cols[a] * P + jacobian.cols[b])] += jacobian.values[a] * jacobian.values[b];
    return out;
}

/// f0, ks, kd of every channel, as the model has them.
std::vector<double> Channels(const Parameters &p)
{
    std::vector<double> out;
    for (const auto &optics : p.optics) out.insert(out.end(), {optics[0], 1.0, optics[1]});
    return out;
}

/// The same of the compressed problem.
Point CompressedPoint(const ff_problem *problem, const ff_model &m, const ff_fit_options &o, const Parameters &p)
{
    Point out = {NAN, std::vector<double>(P), std::vector<double>(P * P)};
    double shape[FF_MAX_SHAPE];
    ff_model_defaults(&m, 1, shape, nullptr);
    for (int k = 0; k < SHAPE; k++) shape[k] = p.shape[k];
    const ff_status status =
        compressed_point(problem, &m, &o, CHANNELS, shape, Channels(p).data(), &out.cost, out.gradient.data(), out.gram.data());
    FF_CHECK(status == FF_OK, "%s", ff_status_str(status));
    return out;
}

void ComparePoints(const char *what, const Point &compressed, const Point &plain)
{
    double scale = 0, worst = 0, worst_gram = 0;
    FF_CHECK(std::fabs(compressed.cost - plain.cost) <= 1e-12 * plain.cost, "%s: costs %.17g and %.17g", what, compressed.cost,
             plain.cost);
    /* a gradient is a sum with cancellations: its rounding is relative to |J_k| |r|, the length of what is summed */
    for (size_t k = 0; k < P; k++) {
        const double length = std::sqrt(plain.gram[k * P + k] * 2 * plain.cost),
                     error = std::fabs(compressed.gradient[k] - plain.gradient[k]) / length;
        worst = std::fmax(worst, error);
        scale = std::fmax(scale, std::fabs(plain.gradient[k]) / length);
        FF_CHECK(error <= 1e-11, "%s: gradient %zu is %.17g, plain %.17g", what, k, compressed.gradient[k], plain.gradient[k]);
        for (size_t j = 0; j <= k; j++) {
            const double size = std::sqrt(plain.gram[k * P + k] * plain.gram[j * P + j]),
                         e = std::fabs(compressed.gram[k * P + j] - plain.gram[k * P + j]) / size;
            worst_gram = std::fmax(worst_gram, e);
            FF_CHECK(e <= 1e-11, "%s: J^T J %zu %zu is %.17g, plain %.17g", what, k, j, compressed.gram[k * P + j],
                     plain.gram[k * P + j]);
        }
    }
    FF_CHECK(scale > 1e-3, "%s: the gradient nearly vanishes at the point of comparison, which shows nothing", what);
    printf("%-34s same point: cost %.1e, gradient %.1e, J^T J %.1e", what, std::fabs(compressed.cost / plain.cost - 1), worst,
           worst_gram);
}

/// Solves the plain problem from p, further than the compressed one goes.
double SolvePlain(ceres::Problem *problem, Parameters *p)
{
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-16;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    for (int c = 0; c < CHANNELS; c++)
        for (int k = 0; k < OPTICS; k++) {
            problem->SetParameterLowerBound(p->optics[c], k, 0);
            problem->SetParameterUpperBound(p->optics[c], k, 1);
        }
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem, &summary);
    FF_CHECK(summary.IsSolutionUsable(), "the plain problem was not solved: %s", summary.message.c_str());
    return summary.final_cost;
}

/// Parameter k of the plain problem: of a channel's f0, ks, kd the first and the last.
double Fitted(const ff_fit_result &r, size_t k)
{
    if (k < SHAPE) return r.shape_value[k].value;
    return r.channel_value[(k - SHAPE) / OPTICS * r.model.n_channel + (k - SHAPE) % OPTICS * 2].value;
}

void CompareOptima(const char *what, const ff_fit_result &r, double plain_cost, const Parameters &p)
{
    double worst = 0;
    FF_CHECK(r.outcome == FF_CONVERGED, "%s: %s", what, ff_outcome_name(r.outcome));
    FF_CHECK(std::fabs(r.residual.objective - plain_cost) <= 1e-10 * plain_cost, "%s: the optima are %.17g and %.17g", what,
             r.residual.objective, plain_cost);
    const double *plain = p.shape;
    for (size_t k = 0; k < P; k++) {
        const double a = Fitted(r, k), b = k < SHAPE ? plain[k] : (&p.optics[0][0])[k - SHAPE];
        worst = std::fmax(worst, std::fabs(a - b));
        /* Both optima have the same cost within 1e-10 of it: d^T J^T J d <= 1e-10 |r|^2, so that a parameter is no further off than
         * sqrt(1e-10 |r|^2 (J^T J)^-1_kk). Its standard error is the root of |r|^2 / N (J^T J)^-1, of (J^T J)^-1 where residuals
         * are in standard deviations; errors that allow for unequal variances differ from that by up to some three times. */
        const double squares = std::fmax(SAMPLES * CHANNELS, 2 * plain_cost);
        const ff_fit_value &v =
            k < SHAPE ? r.shape_value[k] : r.channel_value[(k - SHAPE) / OPTICS * r.model.n_channel + (k - SHAPE) % OPTICS * 2];
        const double error = std::isfinite(v.std_error) ? v.std_error : 0;
        FF_CHECK(std::fabs(a - b) <= 1e-9 + 3 * std::sqrt(1e-10 * squares) * error, "%s: parameter %zu is %.12g, plain %.12g", what,
                 k, a, b);
        /* the data of seed 0 determine everything well */
        FF_CHECK(ff_test_seed() != 0 || std::fabs(a - b) <= 1e-6, "%s: parameter %zu is %.12g, plain %.12g", what, k, a, b);
    }
    printf("; optimum: cost %.1e, parameters %.1e\n", std::fabs(r.residual.objective / plain_cost - 1), worst);
}

ff_table Samples(size_t n, int weights)
{
    const fit_surface s =
        fit_surface_make("ggx+lambert", CHANNELS, "alpha_x=0.2 alpha_y=0.45 r_xy=0.4 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02");
    fit_sampling how = fit_sampling();
    how.n = n, how.max_theta = 80, how.noise = 0.05, how.sigma = 1, how.seed = 31;
    ff_table t = fit_measure(&s, &how);
    uint64_t state = ff_test_stream("equivalence");
    for (size_t i = 0; i < t.n * CHANNELS; i += 97) t.value[i] += 0.3 * fit_uniform(&state); /* something for the robust losses */
    if (!weights) return t;
    t.weight = static_cast<double *>(malloc(t.n * sizeof(double)));
    for (size_t i = 0; i < t.n && t.weight; i++) t.weight[i] = 0.01 + fit_uniform(&state);
    return t;
}

void Compare(const Setting &setting)
{
    ff_table t = Samples(SAMPLES, setting.weighting == FF_WEIGHT_SOLID_ANGLE);
    ff_model m;
    ff_problem *compressed = nullptr;
    ff_fit_result r;
    ff_error err = {};
    ff_fit_options o = fit_options();
    o.loss = setting.loss;
    o.robust = setting.robust;
    o.robust_scale = setting.robust_scale;
    o.weighting = setting.weighting;
    o.max_theta = 90 * FIT_DEGREE;
    o.shape = FF_SHAPE_CORRELATED;
    ff_status status = ff_model_parse("ggx+lambert", &m, &err);
    if (!status) status = ff_problem_make(&t, &m, 1, &o, &compressed, &err);
    FF_CHECK(status == FF_OK, "%s: %s", setting.what, err.message);
    if (!status) {
        Parameters p = {{0.3, 0.35, 0.1}, {{0.7, 0.2}, {0.5, 0.1}, {0.4, 0.05}}};
        ceres::Problem plain;
        AddResiduals(t, setting, &p, &plain);
        ComparePoints(setting.what, CompressedPoint(compressed, m, o, p), PlainPoint(&plain, &p));
        status = ff_problem_fit_into(compressed, &m, &o, &r, &err);
        FF_CHECK(status == FF_OK, "%s: %s", setting.what, err.message);
        if (!status) {
            CompareOptima(setting.what, r, SolvePlain(&plain, &p), p);
            ff_fit_result_clear(&r);
        }
    }
    ff_problem_free(compressed);
    ff_table_clear(&t);
}

void losses()
{
    Compare({"cosine", FF_LOSS_COSINE, FF_ROBUST_NONE, 1, FF_WEIGHT_SAMPLE});
    Compare({"log", FF_LOSS_LOG, FF_ROBUST_NONE, 1, FF_WEIGHT_SAMPLE});
}

void robust_losses()
{
    static const char *const names[][2] = {
        {"", ""}, {"cosine, huber", "log, huber"}, {"cosine, cauchy", "log, cauchy"}, {"cosine, tukey", "log, tukey"}};
    for (int robust = FF_ROBUST_HUBER; robust < FF_ROBUST_TUKEY; robust++)
        for (int log = 0; log < 2; log++)
            Compare(
                {names[robust][log], log ? FF_LOSS_LOG : FF_LOSS_COSINE, static_cast<ff_robust>(robust), 0.01, FF_WEIGHT_SAMPLE});
    /* From the start above Tukey has more than one optimum: a scale that leaves most samples inside. */
    Compare({names[FF_ROBUST_TUKEY][0], FF_LOSS_COSINE, FF_ROBUST_TUKEY, 0.5, FF_WEIGHT_SAMPLE});
    Compare({names[FF_ROBUST_TUKEY][1], FF_LOSS_LOG, FF_ROBUST_TUKEY, 0.5, FF_WEIGHT_SAMPLE});
}

void weightings()
{
    Compare({"cosine, solid angle", FF_LOSS_COSINE, FF_ROBUST_NONE, 1, FF_WEIGHT_SOLID_ANGLE});
    Compare({"log, solid angle", FF_LOSS_LOG, FF_ROBUST_NONE, 1, FF_WEIGHT_SOLID_ANGLE});
    Compare({"cosine, sigma", FF_LOSS_COSINE, FF_ROBUST_NONE, 1, FF_WEIGHT_SIGMA});
    Compare({"log, sigma", FF_LOSS_LOG, FF_ROBUST_NONE, 1, FF_WEIGHT_SIGMA});
    Compare({"cosine, sigma, cauchy", FF_LOSS_COSINE, FF_ROBUST_CAUCHY, 2, FF_WEIGHT_SIGMA});
}

} // namespace

FF_TEST_MAIN(FF_TEST(losses), FF_TEST(robust_losses), FF_TEST(weightings))
