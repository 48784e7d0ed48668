/* A material with its controls, as the writers of files read it. */
#include "internal_files.h"
#include <math.h>
#include <string.h>

double ff_scene_control(const ff_scene *s, const char *name, size_t c, double otherwise)
{
    for (size_t k = 0; k < ff_control_count(s->material); k++) {
        const ff_control *control = &s->material->control[k];
        if (strcmp(control->made.name, name) != 0) continue;
        return s->control[k * s->n_channels + (control->is_color && s->n_channels > 1 ? c : 0)];
    }
    return otherwise;
}

double ff_scene_setting(const ff_scene *s, const char *name, double otherwise)
{
    for (size_t k = 0; k < FF_TARGET_SETTINGS && s->material->setting[k].name; k++)
        if (!strcmp(s->material->setting[k].name, name)) return s->material->setting[k].value;
    return otherwise;
}

const char *ff_scene_number(double x, char out[FF_NUMBER_TEXT + 1])
{
    out[ff_number_write(isfinite(x) ? x : 0, out)] = '\0';
    return out;
}

void ff_scene_color(const ff_scene *s, const char *name, const char *between, FILE *out)
{
    char text[FF_NUMBER_TEXT + 1];
    for (size_t c = 0; c < 3; c++) fprintf(out, "%s%s", c ? between : "", ff_scene_number(ff_scene_control(s, name, c, 1), text));
}

void ff_scene_put(const ff_scene *s, const char *name, double otherwise, FILE *out)
{
    char text[FF_NUMBER_TEXT + 1];
    fputs(ff_scene_number(ff_scene_control(s, name, 0, otherwise), text), out);
}
