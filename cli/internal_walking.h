/* What the commands share that follow paths of light. */
#ifndef FF_INTERNAL_WALKING_H
#define FF_INTERNAL_WALKING_H
#include "internal_cli.h"
#include "ff_height_field.h"
#include "ff_walk.h"

/* The options that the flags say, with so many paths and these orders where they do not; a usage error for those that nothing needs
 * where --walk is not given. Exit status. Whoever runs them ends the progress (cli_progress_end) where o->progress is set. */
int cli_walk_read(const cli_args *args, uint64_t paths, const char *orders, ff_walk_options *o);

/* The same of --surface, with what both have as `walk` has it. Exit status. */
int cli_surface_read(const cli_args *args, const ff_walk_options *walk, ff_height_field_options *o);

#endif
