/* Style and scripts of the pages: part of the program, as assets/ has them. */
#include "internal_page.h"

/* ASSET_<NAME>_<EXTENSION>: the bytes of a file of assets/, put there by cmake/embed_files.cmake when they change. */
#include <embedded_assets.inc>

#define PUT(asset, out) fwrite(asset, 1, sizeof(asset), out)

void ff_page_put_style(FILE *out)
{
    PUT(ASSET_STYLE_CSS, out);
}

void ff_page_put_scripts(ff_page_kind kind, FILE *out)
{
    PUT(ASSET_PAGE_JS, out);
    PUT(ASSET_CHART_JS, out);
    if (kind == FF_PAGE_TABLE) {
        PUT(ASSET_TABLE_JS, out);
        return;
    }
    PUT(ASSET_MODEL_JS, out);
    PUT(ASSET_PLOTS_JS, out);
    PUT(ASSET_SPHERES_JS, out);
    if (kind == FF_PAGE_COMPARISON)
        PUT(ASSET_COMPARISON_JS, out);
    else
        PUT(ASSET_FIT_JS, out);
}
