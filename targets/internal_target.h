/* Renderers as targets of a fit: what each evaluates, and what its numbers are in terms of the model's.
 *
 * A number that is typed into another renderer than the one it was made for is wrong where masking, Fresnel or the coupling of the
 * diffuse part differ; a fit of what the renderer itself evaluates is not. So a target says, for each of its materials, the model
 * that is the material's, within which bounds, and every control of the renderer as a function of the model's parameters. The
 * derivatives of these functions carry the errors of the fit over. A renderer is one file in renderers/ and one line in
 * targets.def; the functions are in formulas.c, since most conventions are shared. */
#ifndef FF_INTERNAL_TARGET_H
#define FF_INTERNAL_TARGET_H
#include "models/model_struct.h"

enum { FF_FORMULA_INPUTS = 3 };

/* A number as a function of others. */
typedef struct ff_formula {
    const char *name;                  /* of what it gives                                             */
    const char *of[FF_FORMULA_INPUTS]; /* names of its inputs; NULL = no more                          */
    /* The value at the inputs x, and into d, unless NULL, its derivatives by them. Defined on the whole box of the inputs. */
    double (*value)(const double *x, double *d);
} ff_formula;

/* What a person sets in the renderer. */
typedef struct ff_control {
    ff_formula made;  /* from the model's parameters; its name is the renderer's                       */
    double lo, hi;    /* what the renderer takes                                                       */
    const char *unit; /* "1", "turns", "rad", "deg"                                                    */
    int is_color;     /* 1: one value per channel; 0: of a per-channel parameter the one that all channels share */
    int is_of_axis;   /* 1: says nothing of an isotropic surface                                       */
} ff_control;

/* What the renderer has to be told besides, so that it evaluates this. */
typedef struct ff_setting {
    const char *name;
    double value;
} ff_setting;

enum { FF_TARGET_HOLDS = 6, FF_TARGET_CONTROLS = 8, FF_TARGET_PARAMETERS = 8, FF_TARGET_SETTINGS = 4, FF_TARGET_ALIASES = 5 };

/* One way in which a renderer can show a surface. */
typedef struct ff_material {
    const char *name;                           /* "dielectric", "metal"                                          */
    const char *title;                          /* the renderer's words: "Principled BSDF, Metallic 0"            */
    const char *expression;                     /* of the model that the renderer evaluates                       */
    const char *hold[FF_TARGET_HOLDS];          /* "eta=1.5"; NULL = no more, in all of these                     */
    const char *vary[FF_TARGET_HOLDS];          /* parameters that are held unless freed: "ks"                    */
    const char *bound[FF_TARGET_HOLDS];         /* "alpha=0.0001:1"                                               */
    const char *shared[FF_TARGET_HOLDS];        /* per-channel parameters with one value for all channels: "eta"  */
    ff_control control[FF_TARGET_CONTROLS];     /* ends with a NULL name                                */
    ff_formula parameter[FF_TARGET_PARAMETERS]; /* the way back: the model's parameters from the controls, without derivatives */
    ff_setting setting[FF_TARGET_SETTINGS];
} ff_material;

typedef struct ff_target {
    const char *name;                     /* as on the command line: "three-r187"                           */
    const char *alias[FF_TARGET_ALIASES]; /* other names; NULL = no more                                    */
    const char *title, *version, *source;
    const char *lacks;           /* what it has no controls for, and where the model is not all of it                */
    const char *rendered;        /* by what the model was compared with the renderer; NULL: it was not rendered      */
    const ff_material *material; /* [n_materials] */
    size_t n_materials;
} ff_target;

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
