/* Renderers as targets of a fit: what each evaluates, and what its numbers are in terms of the model's.
 *
 * A number that is typed into another renderer than the one it was made for is wrong where masking, Fresnel or the coupling of the
 * diffuse part differ; a fit of what the renderer itself evaluates is not. So a target says, for each of its materials, the model
 * that is the material's, within which bounds, and every control of the renderer as a function of the model's parameters. The
 * derivatives of these functions carry the errors of the fit over. A renderer is one file in renderers/ and one line in
 * targets.def; the functions are in conventions/, since most of them are shared. */
#ifndef FF_INTERNAL_TARGET_H
#define FF_INTERNAL_TARGET_H
#include "models/model_struct.h"
#include "targets/conventions/internal_material.h"

/* The registry. */
size_t ff_target_count(void);
const ff_target *ff_target_at(size_t i);                                             /* NULL when i >= count               */
const ff_target *ff_target_find(const char *name);                                   /* by name or alias; NULL when unknown */
const ff_material *ff_material_find(const ff_target *t, const char *name, size_t n); /* by the first n characters of name; NULL */
size_t ff_control_count(const ff_material *m);

/* The model of a material, with what is held, free and bounded there. FF_ERR_MEMORY aside it cannot fail: a test makes them all. */
ff_status ff_material_model(const ff_material *m, ff_model *out, ff_error *err);

/* The first material of t whose model is m with these parameters, as ff_model_eval: what the material holds has the value there,
 * what it shares is shared. NULL: there is none. */
const ff_material *ff_material_of_model(const ff_target *t, const ff_model *m, size_t n_channels, const double *shape,
                                        const double *channel);

/* A control from the parameters of a model of the material, in channel c (0 unless it is a colour); shape, channel as
 * ff_model_eval. ref, d [FF_FORMULA_INPUTS]: the parameters it was made of, kind FF_PARAM_NONE after the last, and its derivatives
 * by them; both may be NULL. Beyond the range of the renderer too: compare with lo and hi. */
double ff_control_value(const ff_control *k, const ff_model *m, const double *shape, const double *channel, size_t c,
                        ff_param_ref *ref, double *d);

/* The parameters of the model from controls [ff_control_count][n_channels], of which those that are no colours are read in channel
 * 0; all others of the model are left as they are. */
void ff_material_parameters(const ff_material *m, const ff_model *model, size_t n_channels, const double *control, double *shape,
                            double *channel);
#endif
