/* What the rooms share of a composed model below the public headers: its descriptors, what its parameters are to the kernels, and
 * the model made ready for its samples. */
#ifndef FF_INTERNAL_MODEL_H
#define FF_INTERNAL_MODEL_H
#include "model_struct.h"
#include "models/kernels/internal_kernel.h"

/* ---- registry.c ------------------------------------------------------------------------------ */

/* Descriptors by index in models.def; the range is the caller's matter. */
const ff_ndf *ff_ndf_at(int ndf);
const ff_masking *ff_masking_at(int masking);
const ff_fresnel *ff_fresnel_at(int fresnel);
const ff_diffuse *ff_diffuse_at(int diffuse);

/* ---- lobes.c: what the parameters are to the kernels ----------------------------------------- */

/* Bit set (1u << FF_G_...) of the planes that a model's kernels read in a mode; isotropic lobes stay in theirs. */
uint32_t ff_model_planes(const ff_model *m, ff_stretch_mode mode);

/* Does the distribution have the common stretch, so that one alpha may stand for alpha_x ... slope_y? */
static inline int ff_ndf_is_stretched(const ff_ndf *ndf)
{
    return ndf->stretch == NULL;
}

/* Parameters of lobe l for the shape parameters [n_shape] of m: ndf, masking, s and masking_own of the pass are set. jac [n_shape
 * of the lobe][FF_D_COUNT] = d (stretch, own, masking) / d parameter of the lobe; may be NULL. */
void ff_model_lobe(const ff_model *m, uint32_t l, const double *shape, ff_lobe_pass *pass, double jac[][FF_D_COUNT]);

/* Weight of each lobe [n_lobes], and its derivatives by the lobes' parameters `weight`, dw[parameter's lobe][lobe]; may be NULL. */
void ff_model_weights(const ff_model *m, const double *shape, double *weight, double dw[][FF_MAX_LOBES]);

/* ---- box.c ----------------------------------------------------------------------------------- */

/* Where the values of a parameter of m have a meaning: its own descriptor, or of a reflectance that the model is affine in one that
 * goes beyond 1. */
const ff_param *ff_model_param_domain(const ff_model *m, const ff_model_param *p);

/* The upper end of the box that a fit keeps to unless it is told otherwise. */
double ff_param_box_end(const ff_param *info);

/* ---- parameters.c ---------------------------------------------------------------------------- */

/* Do both mean the same parameter of a model? */
static inline int ff_param_is(ff_param_ref a, ff_param_ref b)
{
    return a.kind == b.kind && a.index == b.index;
}

/* Place of a parameter that is one of m's. */
static inline ff_param_ref ff_model_param_ref(const ff_model *m, const ff_model_param *p)
{
    return p >= m->channel && p < m->channel + m->n_channel ? (ff_param_ref){FF_PARAM_CHANNEL, (uint32_t)(p - m->channel)}
                                                            : (ff_param_ref){FF_PARAM_SHAPE, (uint32_t)(p - m->shape)};
}

/* The parameter at a place that m has, to be changed. */
static inline ff_model_param *ff_model_param_of(ff_model *m, ff_param_ref ref)
{
    return ref.kind == FF_PARAM_SHAPE ? &m->shape[ref.index] : &m->channel[ref.index];
}

/* FF_ERR_UNKNOWN with the names that exist. */
ff_status ff_model_unknown_param(const ff_model *m, const char *name, ff_error *err);

/* As ff_model_check, of the values alone: the profile of a `tabulated` lobe may be missing yet. */
ff_status ff_model_check_values(const ff_model *m, size_t n_channels, const double *shape, const double *channel, ff_error *err);

/* Is name "alpha" or "lobe2.alpha", standing for two axes that the model has? Then their names go to x, y. 0 also for a parameter
 * that is called so itself. */
int ff_model_alpha_axes(const ff_model *m, const char *name, char x[FF_PARAM_NAME], char y[FF_PARAM_NAME]);

/* Gives a per-channel parameter one value for all channels in fits of m, or an alpha_y that of alpha_x. FF_ERR_UNKNOWN. */
ff_status ff_model_share(ff_model *m, const char *name, ff_error *err);

/* Reads the decimal number that stands from text to `end`. FF_ERR_SYNTAX. */
ff_status ff_model_number(const char *text, const char *end, double *out, ff_error *err);

/* ---- compose.c ------------------------------------------------------------------------------- */

/* Checks that the terms go together and lists the parameters of lobes and bases in their order; the indices are valid.
 * FF_ERR_UNSUPPORTED as ff_model_parse. */
ff_status ff_model_finish(ff_model *m, ff_error *err);

/* Lobe l of m as a model of its own, without the lobe's weight; out_shape [FF_MAX_SHAPE], out_channel [n_channels][out->n_channel].
 */
void ff_model_lobe_alone(const ff_model *m, uint32_t l, size_t n_channels, const double *shape, const double *channel,
                         ff_model *out, double *out_shape, double *out_channel);

/* ---- prepare.c, coupling.c ------------------------------------------------------------------- */

/* Makes m ready. shape, channel as ff_model_eval, checked before; mode for the lobes that are not isotropic; wanted NULL: the value
 * alone. tan2_lo, tan2_hi: range of tan^2 theta over all directions to come, 0 and INFINITY when unknown. channel and m must
 * outlive it. FF_ERR_MEMORY: *out is of no use then, and holds nothing. */
ff_status ff_prepare(const ff_model *m, const struct ff_kernels *k, ff_stretch_mode mode, size_t n_channels, const double *shape,
                     const double *channel, const ff_wanted *wanted, double tan2_lo, double tan2_hi, ff_prepared *out);
void ff_prepared_free(ff_prepared *p);

/* Fills the curves that the couplings of p need (albedo, loss, f_average); p is otherwise ready. FF_ERR_MEMORY. */
ff_status ff_coupling_fill(ff_prepared *p);

/* p->planes after a change of its lobes' modes. */
uint32_t ff_prepared_planes(const ff_prepared *p);
#endif
