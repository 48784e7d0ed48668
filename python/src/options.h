/* What a fit is asked for, as _fit.py makes it of what a person says, with all that the library borrows of it. */
#ifndef FACETFIT_OPTIONS_H
#define FACETFIT_OPTIONS_H
#include "bind.h"
#include "model.h"
#include <list>
#include "ff_aperture.h"

namespace bind
{
struct asking {
    std::list<std::string> words;
    std::list<std::vector<double>> lists;
    std::vector<ff_bound> bound;
    std::vector<ff_prior> prior;
    std::vector<ff_tie> tie;
    std::vector<ff_fixed> fixed;
    ff_constraints constraints = {};
    std::shared_ptr<noise> of;
    ff_aperture aperture = {};
    ff_fit_options fit;
    ear ears;

    explicit asking(const py::dict &o);
    asking(const asking &) = delete;
    asking &operator=(const asking &) = delete;
    /* The word, for as long as this lives. */
    const char *keep(const std::string &word);

  private:
    const char *keep_channel(const py::handle &channel);
    void take_constraints(const py::dict &o);
    void take_fit(const py::dict &o);
};

/* The number of a word among those that a list of the library has. */
int found(const py::dict &o, const char *key, int (*find)(const char *), const char *(*name)(int));
} // namespace bind
#endif
