/* Goniometer tables of planetary science, as the PHIRE-2 instrument of the University of Bern writes them: rows of reflectance
 * factors, one per pair of directions and band.
 *
 *     # 'counter', 'incidence', 'emission', 'azimuth', 'phase', 'reflectance_factor', 'standard_deviation', 'error_estimate',
 *       'quality_flag', 'absolute_time', 'relative_time', 'bandpass_central', 'bandpass_FWHM', 'sample_temperature', ...
 *     000000, 0.00, 80.00, 90.00, 80.00, 0.79146, 0.1338897162, 1.94936, 5, 1584089229.0, 0.0, 450.00, 70.00, ...
 *
 * Read are, by name: incidence, emission and azimuth in degrees; phase, the angle between the two directions, which says on which
 * side azimuth 0 is (that of the light, in the published files); reflectance_factor = pi f; bandpass_central in nm;
 * standard_deviation.
 *
 * The standard deviation is that of repeated readings, in percent of the reflectance factor. The layout is not documented; that
 * follows from a file of 7824 rows: deviation times reflectance factor takes the steps of a digitiser (0.0046, 0.0080, ...), and
 * third differences along the emission angle are what 1/100 of it would give and 1/45 of what it would give as an absolute one.
 * Where all readings were alike it is 0. error_estimate is one number per band: the calibration's uncertainty, in percent, which is
 * common to all rows and no noise. It is not read, nor is quality_flag, whose values no published text explains. */
#include "data_formats/formats/csv/internal_csv.h"

static const ff_csv_layout layout = {
    .format = "planetary",
    .columns = "theta_i=incidence,phi_i=0,theta_o=emission,phi_o=azimuth,phase=phase,f=reflectance_factor,"
               "sigma=standard_deviation:%,wavelength=bandpass_central",
    .quantity = FF_REFLECTANCE_FACTOR,
    .zero_sigma_is_small = 1,
    .note =
        "standard_deviation is taken as percent of the value, the scatter of repeated readings: the calibration's error_estimate "
        "comes on top",
};

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    const int is = ff_csv_layout_probe(&layout, head, n);
    return is > 0 ? 95 : is;
}

static ff_status read_planetary(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    return ff_csv_read_columns(path, o, &layout, out, err);
}

const ff_format ff_format_planetary = {
    .name = "planetary",
    .title = "goniometer reflectance factors by incidence, emission and azimuth (PHIRE-2 and alike)",
    .extensions = "",
    .source = "the columns' names in published files (Mastcam-Z calibration targets, University of Bern 2020)",
    .probe = probe,
    .reads = FF_READS_PART | FF_READS_QUANTITY,
    .read = read_planetary,
};
