#include "oiio_bridge.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <string>

#include <OpenImageIO/imageio.h>
#include <sys/stat.h>

/// An image that is open.
struct ff_image {
    std::unique_ptr<OIIO::ImageInput> input;
    std::string path;
};

namespace
{

/// A file of so many bytes cannot be worth an image much larger: deflate, the densest in use, makes 1032 bytes of one.
constexpr double kSmallImage = 32e6, kExpansion = 1200;
/// Floats of one band of lines.
constexpr double kBandFloats = 1 << 21;

void SetText(const std::string &from, char (&to)[FF_IMAGE_NAME])
{
    std::snprintf(to, sizeof to, "%s", from.c_str());
}

int BitsOf(const OIIO::TypeDesc &type)
{
    return type.is_floating_point() ? 0 : static_cast<int>(8 * type.basesize());
}

ff_status Describe(const OIIO::ImageSpec &spec, const char *kind, const std::string &path, ff_image_info *info, ff_error *err)
{
    const auto fail = [&](ff_status code, const std::string &found, const char *expected) {
        return ff_error_set(err, code, path.c_str(), 0, -1, "found %s, expected %s", found.c_str(), expected);
    };
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.deep)
        return fail(FF_ERR_UNSUPPORTED, spec.deep ? "deep pixels" : "a volume", "an image of two dimensions");
    if (spec.nchannels < 1 || spec.nchannels > FF_IMAGE_CHANNELS)
        return fail(FF_ERR_UNSUPPORTED, std::to_string(spec.nchannels) + " channels", "1 to 64");
    const double pixels = static_cast<double>(spec.width) * spec.height;
    struct stat st;
    const double file = stat(path.c_str(), &st) == 0 ? static_cast<double>(st.st_size) : 0;
    const double most = std::max(kSmallImage, kExpansion * file);
    if (pixels * static_cast<double>(spec.pixel_bytes(true)) > most)
        return fail(FF_ERR_FORMAT, std::to_string(spec.width) + " x " + std::to_string(spec.height) + " pixels",
                    "a file that is large enough to hold them");
    const double line = static_cast<double>(spec.width) * spec.nchannels;
    const double band = spec.tile_height > 0 ? spec.tile_height : std::max(1.0, std::min(64.0, kBandFloats / line));
    const double tile_width = std::max(spec.tile_width, 1);
    if (4 * band * (line + tile_width * spec.nchannels) > most)
        return fail(FF_ERR_FORMAT,
                    "tiles of " + std::to_string(spec.tile_width) + " x " + std::to_string(spec.tile_height) + " pixels",
                    "a file that is large enough to hold them");
    *info = ff_image_info{};
    info->width = spec.width;
    info->height = spec.height;
    info->n_channels = static_cast<size_t>(spec.nchannels);
    info->alpha = spec.alpha_channel;
    info->bits = BitsOf(spec.format);
    info->band = static_cast<long>(band);
    info->gamma = spec.get_float_attribute("oiio:Gamma", 0);
    // PFM is linear; the library says Rec. 709 of all that looks like PNM.
    const bool pfm = std::string(kind) == "pnm" && info->bits == 0;
    if (!pfm) SetText(spec.get_string_attribute("oiio:ColorSpace", ""), info->encoding);
    for (size_t c = 0; c < info->n_channels; c++) SetText(spec.channel_name(static_cast<int>(c)), info->name[c]);
    return FF_OK;
}

ff_status Open(const char *path, const char *kind, ff_image **out, ff_image_info *info, ff_error *err)
{
    OIIO::ImageSpec wishes; // the numbers of the file, not what a viewer would make of them
    wishes.attribute("oiio:UnassociatedAlpha", 1);
    wishes.attribute("oiio:RawColor", 1);
    auto image = std::make_unique<ff_image>();
    image->path = path;
    image->input = OIIO::ImageInput::create(kind); // this one and no other
    OIIO::ImageSpec spec;
    if (!image->input || !image->input->open(path, spec, wishes)) {
        const std::string reason = image->input ? image->input->geterror() : OIIO::geterror();
        return ff_error_set(err, FF_ERR_FORMAT, path, 0, -1, "OpenImageIO cannot read it (%s), expected an image",
                            reason.empty() ? "no reason given" : reason.c_str());
    }
    image->input->threads(1);
    const ff_status status = Describe(image->input->spec(), kind, image->path, info, err);
    if (status == FF_OK)
        *out = image.release();
    else
        (void)image->input->geterror(); // an error that nobody has asked for would be printed
    return status;
}

ff_status Lines(ff_image &image, long first, long count, float *out, ff_error *err)
{
    OIIO::ImageInput &input = *image.input;
    const OIIO::ImageSpec &spec = input.spec();
    const int y = spec.y + static_cast<int>(first), end = y + static_cast<int>(count);
    const bool done = spec.tile_width ? input.read_tiles(0, 0, spec.x, spec.x + spec.width, y, end, spec.z, spec.z + 1, 0,
                                                         spec.nchannels, OIIO::TypeDesc::FLOAT, out)
                                      : input.read_scanlines(0, 0, y, end, spec.z, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, out);
    const std::string reason = input.geterror();
    if (done) return FF_OK;
    return ff_error_set(err, FF_ERR_READ, image.path.c_str(), 0, -1,
                        "OpenImageIO cannot read lines %ld to %ld (%s), expected a whole image", first, first + count - 1,
                        reason.empty() ? "no reason given" : reason.c_str());
}

/// Runs what must not throw.
template <class F>
ff_status Guarded(const char *path, ff_error *err, F &&call) noexcept
{
    try {
        return call();
    } catch (const std::bad_alloc &) {
        return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for the image");
    } catch (const std::exception &e) {
        return ff_error_set(err, FF_ERR_FORMAT, path, 0, -1, "OpenImageIO failed (%s), expected an image", e.what());
    } catch (...) {
        return ff_error_set(err, FF_ERR_FORMAT, path, 0, -1, "OpenImageIO failed, expected an image");
    }
}

ff_status OpenImage(const char *path, const char *kind, ff_image **out, ff_image_info *info, ff_error *err)
{
    return Guarded(path, err, [&] { return Open(path, kind, out, info, err); });
}

ff_status ReadLines(ff_image *image, long first, long count, float *out, ff_error *err)
{
    return Guarded(image->path.c_str(), err, [&] { return Lines(*image, first, count, out, err); });
}

void CloseImage(ff_image *image)
{
    (void)Guarded("", nullptr, [&] {
        if (image) image->input->close();
        if (image) (void)image->input->geterror();
        delete image;
        return FF_OK;
    });
}

} // namespace

extern "C" __attribute__((visibility("default")))
const ff_image_reader ff_image_reader_v1 = {FF_IMAGE_READER, OpenImage, ReadLines, CloseImage};
