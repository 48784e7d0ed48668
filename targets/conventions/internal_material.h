/* What a renderer is to a fit: its materials, the model of each, and its controls as functions of the model's parameters. */
#ifndef FF_INTERNAL_MATERIAL_H
#define FF_INTERNAL_MATERIAL_H
#include <stddef.h>

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
#endif
