/* Errors, arrays, calls that take long. */
#include "bind.h"
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include "ff_words.h"

namespace bind
{
/* ---- errors ---------------------------------------------------------------------------------- */

void check(ff_status status, const ff_error &err)
{
    if (status == FF_OK) return;
    const char *message = err.message[0] ? err.message : ff_status_str(status);
    py::object line = err.line > 0 ? py::object(py::int_(err.line)) : py::none(),
               byte = err.byte >= 0 && err.path[0] && err.line <= 0 ? py::object(py::int_(err.byte)) : py::none(),
               path = err.path[0] ? py::object(py::str(err.path)) : py::none();
    /* An error that nobody filled has no place. */
    if (err.code == FF_OK) line = byte = py::none();
    py::object made = py::module_::import("facetfit._errors").attr("make")((int)status, message, path, line, byte, (int)err.hint);
    PyErr_SetObject((PyObject *)Py_TYPE(made.ptr()), made.ptr());
    throw py::error_already_set();
}

/* ---- calls that take long -------------------------------------------------------------------- */

namespace
{
struct heard {
    std::string what;
    int iteration; /* -1: no step of the solver */
    double objective;
};
} // namespace

struct ear::hearing {
    std::mutex lock;
    std::condition_variable changed;
    std::deque<heard> queue;
    std::string what;
    bool listens = false, done = false;
};

ear::ear() : in(new hearing)
{
}
ear::~ear() = default;

void ear::hear_progress(void *self, int iteration, double objective)
{
    hearing &in = *static_cast<ear *>(self)->in;
    const std::lock_guard<std::mutex> hold(in.lock);
    if (!in.listens) return;
    in.queue.push_back({in.what, iteration, objective});
    in.changed.notify_one();
}

void ear::hear_busy(void *self, const char *what)
{
    hearing &in = *static_cast<ear *>(self)->in;
    const std::lock_guard<std::mutex> hold(in.lock);
    in.what = what;
    if (!in.listens || !*what) return;
    in.queue.push_back({in.what, -1, 0});
    in.changed.notify_one();
}

namespace
{
/* The exception of Python that is set, kept until it is thrown. */
struct pending {
    std::unique_ptr<py::error_already_set> e;
    void take(volatile int *cancel)
    {
        py::error_already_set now;
        if (!e) e.reset(new py::error_already_set(now));
        *cancel = 1;
    }
};

void tell(const py::object &progress, const heard &h)
{
    if (h.iteration < 0)
        progress(h.what, py::none(), py::none());
    else
        progress(h.what, h.iteration, h.objective);
}
} // namespace

void ear::work(const std::function<void()> &work, const py::object &progress)
{
    std::exception_ptr failed;
    pending raised;
    cancel = 0;
    in->queue.clear();
    in->done = false;
    in->listens = !progress.is_none();
    std::thread worker([&] {
        try {
            work();
        } catch (...) {
            failed = std::current_exception();
        }
        const std::lock_guard<std::mutex> hold(in->lock);
        in->done = true;
        in->changed.notify_one();
    });
    for (bool done = false; !done;) {
        std::deque<heard> now;
        {
            const py::gil_scoped_release others_may;
            std::unique_lock<std::mutex> hold(in->lock);
            in->changed.wait_for(hold, std::chrono::milliseconds(50), [&] { return in->done || !in->queue.empty(); });
            now.swap(in->queue);
            done = in->done;
        }
        if (PyErr_CheckSignals() != 0) raised.take(&cancel);
        for (const heard &h : now) {
            if (raised.e) break;
            try {
                tell(progress, h);
            } catch (py::error_already_set &e) {
                e.restore();
                raised.take(&cancel);
            }
        }
    }
    worker.join();
    in->listens = false;
    if (raised.e) throw *raised.e;
    if (failed) std::rethrow_exception(failed);
}

/* ---- arrays ---------------------------------------------------------------------------------- */

static numbers vectors(const py::object &w, const char *name)
{
    numbers a = numbers::ensure(w);
    if (!a) throw py::error_already_set();
    if (a.ndim() < 1 || a.shape(a.ndim() - 1) != 3)
        throw py::value_error(std::string(name) + ": expected vectors, an array whose last axis has length 3");
    return a;
}

direction_pairs::direction_pairs(const py::object &wi, const py::object &wo)
{
    const numbers in = vectors(wi, "wi"), out = vectors(wo, "wo");
    const numbers &longer = in.ndim() >= out.ndim() ? in : out;
    leading.assign(longer.shape(), longer.shape() + longer.ndim() - 1);
    for (const numbers *a : {&in, &out}) {
        const bool same = std::vector<py::ssize_t>(a->shape(), a->shape() + a->ndim() - 1) == leading;
        if (!same && a->ndim() > 1) throw py::value_error("wi and wo: expected the same shape, or a single vector of one of them");
    }
    count = (size_t)longer.size() / 3;
    room.resize(6 * (count ? count : 1));
    for (size_t side = 0; side < 2; side++) {
        const numbers &a = side ? out : in;
        const double *from = a.data();
        const size_t step = a.ndim() > 1 ? 3 : 0;
        for (size_t k = 0; k < 3; k++) {
            double *to = &room[(3 * side + k) * count];
            for (size_t i = 0; i < count; i++) to[i] = from[i * step + k];
        }
    }
    const double *p = room.data();
    planes = {p, p + count, p + 2 * count, p + 3 * count, p + 4 * count, p + 5 * count};
}

std::vector<py::ssize_t> direction_pairs::shape(size_t channels) const
{
    std::vector<py::ssize_t> all = leading;
    if (channels > 1) all.push_back((py::ssize_t)channels);
    return all;
}

py::array planes_array(std::unique_ptr<double[]> planes, const std::vector<py::ssize_t> &shape, size_t channels, size_t n)
{
    std::vector<py::ssize_t> strides(shape.size());
    py::ssize_t step = sizeof(double);
    size_t axes = shape.size();
    if (channels > 1) strides[--axes] = (py::ssize_t)(n * sizeof(double));
    while (axes-- > 0) {
        strides[axes] = step;
        step *= shape[axes];
    }
    double *p = planes.release();
    const py::capsule owner(p, [](void *all) { delete[] static_cast<double *>(all); });
    return py::array_t<double>(shape, strides, p, owner);
}

py::array_t<double> copied(const double *x, size_t n)
{
    py::array_t<double> a((py::ssize_t)n);
    std::copy(x, x + n, a.mutable_data());
    return a;
}
} // namespace bind

PYBIND11_MODULE(_core, m)
{
    m.doc() = "The C library, as the package facetfit uses it.";
    bind::add_tables(m);
    bind::add_models(m);
    bind::add_tools(m);
    bind::add_studies(m);
    bind::add_retrievals(m);
}
