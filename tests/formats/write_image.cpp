#include "write_image.h"

#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>

extern "C" int write_image(const char *path, int width, int height, int channels, const char *type, const float *pixels,
                           const char *color_space, int tile, const char *names)
{
    OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc(type));
    if (color_space != nullptr) spec.attribute("oiio:ColorSpace", color_space);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.tile_width = spec.tile_height = tile;
    if (names != nullptr) {
        spec.channelnames = OIIO::Strutil::splits(names, ",");
        spec.alpha_channel = -1;
    }
    auto out = OIIO::ImageOutput::create(path);
    const bool done = out && out->open(path, spec) && out->write_image(OIIO::TypeDesc::FLOAT, pixels) && out->close();
    if (!done) OIIO::Strutil::print(stderr, "{}: {}\n", path, out ? out->geterror() : OIIO::geterror());
    return done ? 0 : 1;
}
