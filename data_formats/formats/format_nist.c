/* NIST BRDF and Mueller matrix data: comma-separated rows, one per pair of directions and wavelength.
 *
 *     lambda,thetai,phii,thetar,phir,fr11,m12,...,m44                                     the header as its README has it
 *     lambda,thetai,phi,thetar,phir,f_r11,f_r12/f_r11,...,f_r44/f_r11                     as files have it
 *
 * lambda in micrometres, angles in degrees (thetai may be negative), fr11 the unpolarised BRDF in 1/sr without the cosine; the
 * other elements are relative to it and are not read. Both azimuths are those of the directions away from the surface, as ours are:
 * of the sintered PTFE of Germer 2017 the values rise towards phir - phii = 180 degrees (forward scatter), no pair lies closer than
 * 5 degrees to phir - phii = 0 with equal thetas (where the detector hides the source) while pairs at 180 degrees come within 1
 * degree, and as functions of thetai and of thetar the values agree, as reciprocity asks of a BRDF and not of one times a cosine.
 */
#include "data_formats/formats/csv/internal_csv.h"

static const ff_csv_layout layout = {
    .format = "nist",
    .columns = "wavelength=lambda:um,theta_i=thetai,phi_i=phii|phi,theta_o=thetar,phi_o=phir,f=f_r11|fr11",
    .quantity = FF_BRDF,
};

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    const int is = ff_csv_layout_probe(&layout, head, n);
    return is > 0 ? 95 : is;
}

static ff_status read_nist(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    return ff_csv_read_columns(path, o, &layout, out, err);
}

const ff_format ff_format_nist = {
    .name = "nist",
    .title = "NIST BRDF and Mueller matrix CSV (the unpolarised BRDF)",
    .extensions = "",
    .source = "README of the data of Germer 2017, Applied Optics (sintered PTFE)",
    .probe = probe,
    .reads = FF_READS_PART | FF_READS_QUANTITY,
    .read = read_nist,
};
