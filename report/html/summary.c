/* The core of a page as a part of another one. */
#include "internal_html.h"

ff_status ff_html_summary_write(const ff_report_fits *r, ff_isa isa, FILE *out, ff_error *err)
{
    ff_html_subject s;
    ff_page p = {.out = out, .err = err};
    ff_status status = ff_html_subject_make(r, NULL, isa, &s, err);
    if (!status) {
        ff_page_format(&p, "<div class=\"facetfit\">\n<style>.facetfit caption { caption-side: top; text-align: left; }</style>\n");
        ff_html_verdict(&p, &s);
        if (s.models > 1) ff_html_ranking(&p, &s);
        if (s.models > 1)
            ff_html_parameters(&p, &s, s.shown);
        else
            for (size_t k = 0; k < r->n_fits && k < FF_HTML_CHANNELS; k++) ff_html_parameters(&p, &s, k);
        ff_page_format(&p, "</div>\n");
        status = p.status;
    }
    ff_html_subject_free(&s);
    return status;
}
