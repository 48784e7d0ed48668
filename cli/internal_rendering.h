/* What `render` is made of: the scene of the flags, and the pictures that the command line names. */
#ifndef FF_INTERNAL_RENDERING_H
#define FF_INTERNAL_RENDERING_H
#include "internal_cli.h"
#include "ff_fit_document.h"
#include "ff_render.h"

/* What a word of the command line is; exit status. A file that is there, or a model. */
typedef enum cli_source { CLI_SOURCE_TABLE, CLI_SOURCE_DOCUMENT, CLI_SOURCE_MODEL } cli_source;
int cli_source_of(const char *word, cli_source *out);

/* ---- render_scene.c ---------------------------------------------------------------------------------------------------------- */

/* Light and camera. Zero is a legal one to free. */
typedef struct cli_light {
    ff_render_options options;
    ff_environment *environment;
    double direction[FF_RENDER_LIGHTS_MAX][3];
} cli_light;
/* Exit status; to be freed whatever it is. */
int cli_light_read(const cli_args *args, cli_light *out);
void cli_light_free(cli_light *l);

/* A parameter and the values that it takes in turn: --across, --down. */
typedef struct cli_sweep {
    size_t n; /* 0: not given */
    double value[32];
    char name[CLI_NAME];
} cli_sweep;
int cli_sweep_read(const cli_args *args, cli_flag_id flag, cli_sweep *out);

/* ---- render_subject.c -------------------------------------------------------------------------------------------------------- */

enum { CLI_LABEL = 160 };

/* A picture to be made: the table, or a model. */
typedef struct cli_ball {
    char label[CLI_LABEL];
    const ff_table *table; /* NULL: the model */
    const ff_model *model; /* NULL: of a table that no model goes with */
    size_t n_channels;
    double *shape, *channel; /* owned */
} cli_ball;

/* Everything that pictures are made of. Zero is a legal one to free. */
typedef struct cli_balls {
    ff_table table;
    int has_table;
    ff_fit_document *document;
    cli_tables tables;
    cli_scene *scene; /* [n_scenes] */
    size_t n_scenes;
    size_t n, columns;
    cli_ball *ball; /* [n] row by row */
    int differ;     /* 1: the second less the first is to be shown too */
    int with_data;  /* 1: the first is the table, the second its model */
} cli_balls;
int cli_balls_gather(const cli_args *args, const cli_sweep *across, const cli_sweep *down, cli_balls *out);
void cli_balls_free(cli_balls *b);

#endif
