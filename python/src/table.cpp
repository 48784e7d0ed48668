/* Measured data: read, looked at through views, written. */
#include "table.h"
#include <cmath>
#include "ff_diagnosis.h"
#include "ff_resample.h"
#include "ff_spectral.h"

namespace bind
{
namespace
{
using text = std::optional<std::string>;

const char *given(const text &s)
{
    return s ? s->c_str() : nullptr;
}

/* The number of a name that `name` lists, from `first` on. */
int number_of(const char *what, const text &word, const char *(*name)(int), int first, int otherwise)
{
    if (!word) return otherwise;
    std::string known;
    for (int k = first; name(k); k++) {
        if (*word == name(k)) return k;
        known += (known.empty() ? "" : ", ") + std::string(name(k));
    }
    ff_error err = {};
    check(ff_error_set(&err, FF_ERR_UNKNOWN, nullptr, 0, -1, "%s '%.40s'; known are %s", what, word->c_str(), known.c_str()), err);
    return otherwise;
}

/* ---- reading and making ---------------------------------------------------------------------- */

std::unique_ptr<table> read(const std::vector<std::string> &paths, const text &format, const text &columns, const text &grid,
                            const text &part, const text &quantity, std::optional<double> scale, const text &dialect,
                            const text &azimuth, const text &phi, const text &angles)
{
    ff_read_options o;
    ff_read_options_init(&o);
    o.format = given(format);
    o.columns = given(columns);
    o.grid = given(grid);
    o.part = given(part);
    o.dialect = given(dialect);
    o.quantity = number_of("no quantity", quantity, ff_quantity_name, 0, -1);
    o.azimuth = number_of("no azimuth", azimuth, ff_azimuth_name, 1, 0);
    o.phi = number_of("no sense of azimuths", phi, ff_phi_sense_name, 1, 0);
    o.angles = number_of("no angles", angles, ff_angles_name, 1, 0);
    if (scale) o.scale = *scale;
    std::vector<const char *> names;
    for (const std::string &path : paths) names.push_back(path.c_str());
    ff_table *t = nullptr;
    ff_error err = {};
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = ff_table_read_all(names.data(), names.size(), &o, &t, &err);
    }
    check(status, err);
    return make_table(t, paths.size() == 1 ? paths[0] : paths[0] + " and " + std::to_string(paths.size() - 1) + " more");
}

/* theta and phi of a unit vector. */
void angles_of(const double *w, double *theta, double *phi)
{
    *theta = std::atan2(std::hypot(w[0], w[1]), w[2]);
    *phi = std::atan2(w[1], w[0]);
}

void fill_plane(double *to, const py::object &from, size_t n, size_t channel, size_t channels, const char *what)
{
    const numbers a = numbers::ensure(from);
    if (!a) throw py::error_already_set();
    if ((size_t)a.size() != n * channels)
        throw py::value_error(std::string(what) + ": expected " + std::to_string(n * channels) + " numbers, found " +
                              std::to_string(a.size()));
    for (size_t i = 0; i < n; i++) to[i] = a.data()[i * channels + channel];
}

void name_channels(ff_table *t, size_t channels, const std::vector<std::string> &names, const std::vector<double> &wavelengths)
{
    static const char *const rgb[] = {"r", "g", "b"};
    ff_error err = {};
    if (!names.empty() && names.size() != channels) throw py::value_error("names: expected one for each channel");
    if (!wavelengths.empty() && wavelengths.size() != channels) throw py::value_error("wavelengths: expected one for each channel");
    for (size_t c = 0; c < channels; c++) {
        std::string name = channels == 1 ? "f" : channels == 3 ? rgb[c] : "c" + std::to_string(c);
        const double nm = wavelengths.empty() ? NAN : wavelengths[c];
        if (!std::isnan(nm)) {
            name = py::cast<std::string>(py::str("{:g}nm").format(nm));
        }
        if (!names.empty()) name = names[c];
        check(ff_table_set_channel(t, c, name.c_str(), nm, 1), err);
    }
}

/* f [...] or [...][channels] of pairs of directions. */
std::unique_ptr<table> make(const py::object &wi, const py::object &wo, const py::object &f, const py::object &sigma,
                            const py::object &weight, const std::vector<std::string> &names, const std::vector<double> &wavelengths,
                            bool isotropic)
{
    const direction_pairs w(wi, wo);
    const numbers values = numbers::ensure(f);
    if (!values) throw py::error_already_set();
    if (w.n() == 0 || values.size() == 0 || (size_t)values.size() % w.n())
        throw py::value_error("f: expected one value for each of " + std::to_string(w.n()) +
                              " pairs of directions and each channel, found " + std::to_string(values.size()));
    const size_t n = w.n(), channels = (size_t)values.size() / n;
    if (channels > 1 && (values.ndim() < 2 || (size_t)values.shape(values.ndim() - 1) != channels))
        throw py::value_error("f: expected the channels along its last axis");
    ff_table *t = nullptr;
    ff_error err = {};
    check(ff_table_new(n, channels, !sigma.is_none(), !weight.is_none(), &t, &err), err);
    auto made = make_table(t, "data");
    for (size_t c = 0; c < channels; c++) {
        fill_plane(ff_table_value_plane(t, c), f, n, c, channels, "f");
        if (!sigma.is_none()) fill_plane(ff_table_sigma_plane(t, c), sigma, n, c, channels, "sigma");
    }
    if (!weight.is_none()) fill_plane(ff_table_weight_plane(t), weight, n, 0, 1, "weight");
    const ff_dirs *d = w.dirs();
    for (size_t i = 0; i < n; i++) {
        const double in[3] = {d->wix[i], d->wiy[i], d->wiz[i]}, out[3] = {d->wox[i], d->woy[i], d->woz[i]};
        angles_of(in, &ff_table_angle_plane(t, 0)[i], &ff_table_angle_plane(t, 1)[i]);
        angles_of(out, &ff_table_angle_plane(t, 2)[i], &ff_table_angle_plane(t, 3)[i]);
    }
    name_channels(t, channels, names, wavelengths);
    ff_table_set_isotropic(t, isotropic);
    return made;
}

/* ---- views ----------------------------------------------------------------------------------- */

ff_table *of(const py::object &self)
{
    return self.cast<table &>().t.get();
}

py::object plane_view(const py::object &self, double *plane)
{
    if (!plane) return py::none();
    return py::array_t<double>({(py::ssize_t)ff_table_samples(of(self))}, {(py::ssize_t)sizeof(double)}, plane, self);
}

/* Planes that lie one behind the other, as [n][channels]. */
py::object planes_view(const py::object &self, double *(*plane)(ff_table *, size_t))
{
    ff_table *t = of(self);
    const size_t channels = ff_table_channel_count(t);
    double *first = plane(t, 0);
    if (!first) return py::none();
    const py::ssize_t n = (py::ssize_t)ff_table_samples(t), step = channels > 1 ? plane(t, 1) - first : n;
    for (size_t c = 1; c < channels; c++)
        if (plane(t, c) - first != step * (py::ssize_t)c)
            throw std::runtime_error("the planes of a table do not lie at equal distances");
    const py::ssize_t size = sizeof(double);
    return py::array_t<double>({n, (py::ssize_t)channels}, {size, step * size}, first, self);
}

py::object valid_view(const py::object &self)
{
    ff_table *t = of(self);
    return py::array(py::dtype("bool"), {(py::ssize_t)ff_table_samples(t)}, {1}, ff_table_valid_plane(t), self);
}

/* Unit vectors [n][3] of light and view. */
py::tuple directions_of(const table &self)
{
    const py::ssize_t n = (py::ssize_t)ff_table_samples(self.t.get());
    std::unique_ptr<double[]> room[2] = {std::unique_ptr<double[]>(new double[3 * n + 1]),
                                         std::unique_ptr<double[]>(new double[3 * n + 1])};
    double *planes[6];
    for (int k = 0; k < 6; k++) planes[k] = room[k / 3].get() + (k % 3) * n;
    {
        const py::gil_scoped_release others_may;
        ff_table_directions(self.t.get(), 0, (size_t)n, planes);
    }
    py::array wi = planes_array(std::move(room[0]), {n, 3}, 3, (size_t)n),
              wo = planes_array(std::move(room[1]), {n, 3}, 3, (size_t)n);
    return py::make_tuple(wi, wo);
}

/* Values in 1/sr, [n][channels]. */
py::array values_in_sr(const table &self, bool sigmas)
{
    const ff_table *t = self.t.get();
    const size_t n = ff_table_samples(t), channels = ff_table_channel_count(t);
    std::unique_ptr<double[]> room(new double[n * channels + 1]);
    for (size_t c = 0; c < channels; c++) (sigmas ? ff_table_sigmas : ff_table_values)(t, c, 0, n, room.get() + c * n);
    py::array a = planes_array(std::move(room), {(py::ssize_t)n, (py::ssize_t)channels}, channels, n);
    return a;
}

py::list channels_of(const table &self)
{
    py::list all;
    for (size_t c = 0; c < ff_table_channel_count(self.t.get()); c++) {
        const ff_channel *k = ff_table_channel(self.t.get(), c);
        all.append(py::make_tuple(k->name, k->wavelength_nm, k->scale));
    }
    return all;
}

std::vector<std::string> notes_of(const table &self)
{
    std::vector<std::string> all;
    char one[1024];
    for (size_t k = 0; ff_table_assumption(self.t.get(), k, one, sizeof one, nullptr); k++) all.push_back(one);
    return all;
}

/* ---- what is done with them ------------------------------------------------------------------ */

void write(const table &self, const std::string &path, const text &format)
{
    ff_error err = {};
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = ff_table_write(path.c_str(), given(format), self.t.get(), &err);
    }
    check(status, err);
}

std::unique_ptr<table> reduce(const table &self, const std::string &to)
{
    ff_table *t = nullptr;
    ff_error err = {};
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = ff_table_reduce(self.t.get(), to.c_str(), &t, &err);
    }
    check(status, err);
    return make_table(t, self.path);
}

py::dict report_of(const ff_resample_report &r)
{
    py::dict d;
    d["as_it_is"] = (bool)r.as_it_is;
    d["samples"] = r.n;
    d["at_sample"] = r.at_sample;
    d["between"] = r.between;
    d["reciprocal"] = r.reciprocal;
    d["beyond"] = r.beyond;
    d["below_horizon"] = r.below_horizon;
    d["invalid"] = r.invalid;
    d["raised"] = r.raised;
    d["method"] = r.method;
    d["lost"] = r.lost;
    return d;
}

py::tuple resample(const table &self, const std::string &format, const text &grid, bool beyond, int threads)
{
    const ff_format *to = ff_format_find(format.c_str());
    ff_error err = {};
    if (!to) check(ff_error_set(&err, FF_ERR_UNKNOWN, nullptr, 0, -1, "no format '%.40s'", format.c_str()), err);
    ff_resample_options o;
    ff_resample_options_init(&o);
    o.grid = given(grid);
    o.beyond = beyond;
    o.threads = threads;
    ear ears;
    o.cancel = &ears.cancel;
    ff_table *t = nullptr;
    ff_resample_report report = {};
    report.size = sizeof report;
    ff_status status = FF_OK;
    ears.work([&] { status = ff_resample(self.t.get(), to, &o, &t, &report, &err); }, py::none());
    check(status, err);
    return py::make_tuple(make_table(t, self.path), report_of(report));
}

py::str describe(const table &self, const std::string &form)
{
    content c;
    ff_error err = {};
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = ff_table_describe(self.t.get(), self.path.c_str(), form.c_str(), &c.c, &err);
    }
    check(status, err);
    return c.text();
}

/* Findings (kind, sure, option, value, two numbers), and whether the file leaves open what its angles are. */
py::tuple diagnose(const table &self, double max_theta)
{
    ff_diagnosis g;
    ff_error err = {};
    ff_status status;
    {
        const py::gil_scoped_release others_may;
        status = ff_diagnosis_find(self.t.get(), max_theta, &g);
    }
    check(status, err);
    py::list all;
    for (size_t k = 0; k < g.n; k++) {
        char value[32] = "";
        const char *option = ff_diagnosis_option(&g.finding[k], value);
        all.append(py::make_tuple((int)g.finding[k].kind, (bool)g.finding[k].sure, option ? option : "", value,
                                  g.finding[k].value[0], g.finding[k].value[1]));
    }
    return py::make_tuple(all, (bool)g.open);
}

py::list formats()
{
    py::list all;
    for (size_t i = 0; i < ff_format_count(); i++) {
        const ff_format *f = ff_format_at(i);
        py::dict d;
        d["name"] = ff_format_name(f);
        d["title"] = ff_format_title(f);
        d["extensions"] = ff_format_extensions(f);
        d["source"] = ff_format_source(f);
        d["writable"] = (bool)ff_format_can_write(f);
        all.append(d);
    }
    return all;
}
} // namespace

std::unique_ptr<table> make_table(ff_table *t, const std::string &path)
{
    return std::unique_ptr<table>(new table{table_ptr(t), path});
}

void add_tables(py::module_ &m)
{
    py::class_<table> c(m, "Table");
    c.def_property_readonly("samples", [](const table &t) { return ff_table_samples(t.t.get()); });
    c.def_property_readonly("path", [](const table &t) { return t.path; });
    c.def_property_readonly("format", [](const table &t) { return ff_table_format(t.t.get()); });
    c.def_property_readonly("quantity", [](const table &t) { return ff_quantity_name(ff_table_quantity(t.t.get())); });
    c.def_property_readonly("isotropic", [](const table &t) { return (bool)ff_table_is_isotropic(t.t.get()); });
    c.def_property_readonly("angle_unit", [](const table &t) { return ff_table_angle_unit(t.t.get()); });
    c.def_property_readonly("is_grid", [](const table &t) { return ff_table_grid(t.t.get()) != nullptr; });
    c.def_property_readonly("channels", channels_of);
    c.def_property_readonly("notes", notes_of);
    c.def("values_view", [](const py::object &self) { return planes_view(self, ff_table_value_plane); });
    c.def("sigmas_view", [](const py::object &self) { return planes_view(self, ff_table_sigma_plane); });
    c.def("angle_view", [](const py::object &self, int k) { return plane_view(self, ff_table_angle_plane(of(self), k)); });
    c.def("weight_view", [](const py::object &self) { return plane_view(self, ff_table_weight_plane(of(self))); });
    c.def("valid_view", valid_view);
    c.def("values", [](const table &t) { return values_in_sr(t, false); });
    c.def("sigmas", [](const table &t) { return values_in_sr(t, true); });
    c.def("directions", directions_of);
    c.def("write", write, py::arg("path"), py::arg("format"));
    c.def("reduce", reduce, py::arg("to"));
    c.def("resample", resample, py::arg("format"), py::arg("grid"), py::arg("beyond"), py::arg("threads"));
    c.def("describe", describe, py::arg("form"));
    c.def("diagnose", diagnose, py::arg("max_theta"));
    m.def("read", read, py::arg("paths"), py::arg("format"), py::arg("columns"), py::arg("grid"), py::arg("part"),
          py::arg("quantity"), py::arg("scale"), py::arg("dialect"), py::arg("azimuth"), py::arg("phi"), py::arg("angles"));
    m.def("make_table", make, py::arg("wi"), py::arg("wo"), py::arg("f"), py::arg("sigma"), py::arg("weight"), py::arg("names"),
          py::arg("wavelengths"), py::arg("isotropic"));
    m.def("formats", formats);
}
} // namespace bind
