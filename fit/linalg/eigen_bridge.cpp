/* Eigenvalues by Eigen, which Ceres brings along. */
#include "internal_linalg.h"
#include <Eigen/Eigenvalues>
#include <cstdio>
#include <new>

using matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

extern "C" ff_status ff_symmetric_eigen(const double *A, size_t n, double *values, double *V)
{
    const Eigen::Index N = static_cast<Eigen::Index>(n);
    if (n == 0) return FF_OK;
    try {
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(Eigen::MatrixXd(Eigen::Map<const matrix>(A, N, N)));
        if (solver.info() != Eigen::Success) return FF_ERR_INTERNAL;
        Eigen::Map<Eigen::VectorXd>(values, N) = solver.eigenvalues();
        Eigen::Map<matrix>(V, N, N) = solver.eigenvectors();
    } catch (const std::bad_alloc &) {
        return FF_ERR_MEMORY;
    } catch (...) {
        return FF_ERR_INTERNAL;
    }
    return FF_OK;
}

extern "C" const char *ff_eigen_version(char *out, size_t size)
{
    std::snprintf(out, size, "%d.%d.%d", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
    return out;
}
