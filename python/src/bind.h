/* What the parts of the Python module share: errors, arrays, calls that take long. */
#ifndef FACETFIT_BIND_H
#define FACETFIT_BIND_H
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <functional>
#include <memory>
#include <string>
#include "ff_noise.h"
#include "ff_profile.h"
#include "ff_status.h"
#include "ff_study.h"
#include "ff_table.h"

namespace bind
{
namespace py = pybind11;

/* C-contiguous doubles of whatever was given. */
using numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/* Throws the exception of a status; ends no call that succeeded. */
void check(ff_status status, const ff_error &err);

/* An object of the library with what releases it. */
template <class T, void (*release)(T *)>
struct releaser {
    void operator()(T *p) const
    {
        release(p);
    }
};
using table_ptr = std::unique_ptr<ff_table, releaser<ff_table, ff_table_free>>;
using model_ptr = std::unique_ptr<ff_model, releaser<ff_model, ff_model_free>>;
using noise_ptr = std::unique_ptr<ff_noise, releaser<ff_noise, ff_noise_free>>;
using profile_ptr = std::unique_ptr<ff_profile_table, releaser<ff_profile_table, ff_profile_free>>;
using study_ptr = std::unique_ptr<ff_study, releaser<ff_study, ff_study_free>>;

/* What the library has written, as a Python string, and as bytes. */
struct content {
    ff_content c = {nullptr, 0};
    content() = default;
    content(const content &) = delete;
    content &operator=(const content &) = delete;
    ~content()
    {
        ff_content_clear(&c);
    }
    py::str text() const
    {
        return py::reinterpret_steal<py::str>(PyUnicode_DecodeUTF8(c.text ? c.text : "", (Py_ssize_t)c.n, "replace"));
    }
    py::bytes bytes() const
    {
        return py::bytes(c.text ? c.text : "", c.n);
    }
};

/* How a call that takes long talks to the one who waits: what it is doing, and whether to stop. Its functions that begin with
 * `hear` are called by the library, from the thread that works. */
class ear
{
  public:
    static void hear_progress(void *self, int iteration, double objective);
    static void hear_busy(void *self, const char *what);
    volatile int cancel = 0;

    /* Does `work` on a thread of its own without the interpreter's lock, passes on what is heard to progress(what, iteration,
     * objective), and looks for Ctrl-C meanwhile. An exception of either ends the work, and is thrown when it has ended. */
    void work(const std::function<void()> &work, const py::object &progress);

    ear();
    ~ear();

  private:
    struct hearing;
    std::unique_ptr<hearing> in;
};

/* Vectors [n][3] as six planes [n], as the library takes them; one vector stands for n. */
class direction_pairs
{
  public:
    direction_pairs(const py::object &wi, const py::object &wo);
    size_t n() const
    {
        return count;
    }
    const ff_dirs *dirs() const
    {
        return &planes;
    }
    /* The shape of what there is one of for each pair, with `channels` behind it where there are several. */
    std::vector<py::ssize_t> shape(size_t channels) const;

  private:
    std::vector<double> room;
    std::vector<py::ssize_t> leading;
    size_t count;
    ff_dirs planes;
};

/* Planes [channels][n] as an array of this shape, [...][channels] or [...]. The memory goes with the array. */
py::array planes_array(std::unique_ptr<double[]> planes, const std::vector<py::ssize_t> &leading, size_t channels, size_t n);

/* A copy of [n] numbers as an array. */
py::array_t<double> copied(const double *x, size_t n);

void add_tables(py::module_ &m);
void add_models(py::module_ &m);
void add_tools(py::module_ &m);
void add_studies(py::module_ &m);
void add_retrievals(py::module_ &m);
} // namespace bind
#endif
