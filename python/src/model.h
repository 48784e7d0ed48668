/* Models in Python: an expression with the values of its parameters. */
#ifndef FACETFIT_MODEL_H
#define FACETFIT_MODEL_H
#include "bind.h"

namespace bind
{
struct noise {
    noise_ptr n;
};

struct profile {
    profile_ptr t;
};

/* The values of a model's parameters. */
struct values {
    size_t channels;
    std::vector<double> shape, channel; /* [n_shape], [channels][n_channel] */
};

struct model {
    model_ptr m;
    values own;                     /* what a call does not say           */
    std::shared_ptr<profile> table; /* of `tabulated` lobes; it goes along */

    size_t count(ff_param_kind kind) const
    {
        return ff_model_param_count(m.get(), kind);
    }
    /* The model's own values with those of the call in their places. */
    values with(const py::kwargs &said) const;
    /* One value, or one for each channel, of the parameter `name` ("alpha": both axes). Channels must be enough already. */
    void set(values &v, const char *name, const py::handle &said) const;
};

std::shared_ptr<model> copy_model(const ff_model *m, const std::shared_ptr<profile> &table);
/* Values that a result has found. */
values found_values(const ff_fit_result *fit);
} // namespace bind
#endif
