/* How wide text is, and as much of it as there is room for. */
#include "internal_canvas.h"
#include "report/internal_text.h"
#include <math.h>
#include <string.h>

double ff_run_points(const char *text, size_t length, double size)
{
    double width = 0;
    for (size_t i = 0; i < length;) {
        uint32_t code = '?';
        const size_t n = ff_text_sequence(text + i, &code);
        width += ff_glyph_of(n ? code : '?').width;
        i += n ? n : 1;
    }
    return width * size / 1000;
}

/* ---- runs ------------------------------------------------------------------------------------ */

int ff_run_next(const char **text, ff_run *out)
{
    const char *t = *text;
    if (*t == '\0') return 0;
    const int raised = *t == '^' && t[1] == '{', lowered = *t == '_' && t[1] == '{';
    if (raised || lowered) {
        const size_t n = strcspn(t + 2, "}");
        *out = (ff_run){t + 2, n, raised ? 1 : -1};
        *text = t + 2 + n + (t[2 + n] == '}');
        return 1;
    }
    size_t n = 1;
    while (t[n] && !((t[n] == '^' || t[n] == '_') && t[n + 1] == '{')) n++;
    *out = (ff_run){t, n, 0};
    *text = t + n;
    return 1;
}

double ff_run_rise(int level)
{
    return level > 0 ? FF_RUN_RAISE : level < 0 ? -FF_RUN_RAISE / 2 : 0;
}

double ff_text_points(const char *text, double size)
{
    double width = 0;
    ff_run run;
    while (ff_run_next(&text, &run)) width += ff_run_points(run.text, run.length, run.level ? FF_RUN_SIZE * size : size);
    return width;
}

const char *ff_text_fit(const char *text, double size, double points, char *out, size_t room)
{
    static const char ellipsis[] = "…";
    size_t keep = strlen(text);
    snprintf(out, room, "%s", text);
    if (ff_text_points(text, size) <= points) return out;
    while (keep > 0) {
        keep--;
        while (keep > 0 && ((unsigned char)text[keep] & 0xc0) == 0x80) keep--;
        if (keep + sizeof ellipsis > room) continue;
        memcpy(out, text, keep);
        const char *open = NULL; /* of a subscript that is cut */
        for (size_t i = 0; i + 1 < keep; i++) {
            if ((text[i] == '_' || text[i] == '^') && text[i + 1] == '{') open = text + i;
            if (text[i] == '}') open = NULL;
        }
        if (open) continue;
        memcpy(out + keep, ellipsis, sizeof ellipsis);
        if (ff_text_points(out, size) <= points) return out;
    }
    *out = '\0';
    return out;
}
