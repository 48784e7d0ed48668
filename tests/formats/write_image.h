/* Images for the tests, written by OpenImageIO. */
#ifndef FF_TEST_WRITE_IMAGE_H
#define FF_TEST_WRITE_IMAGE_H
#ifdef __cplusplus
extern "C" {
#endif
/* pixels [height][width][channels] as the file holds them (integers: 0 .. 1). type: "uint8", "uint16", "half", "float".
 * color_space: NULL = none said. tile: 0 = scan lines. names: NULL or comma separated. 0 = done. */
int write_image(const char *path, int width, int height, int channels, const char *type, const float *pixels,
                const char *color_space, int tile, const char *names);
#ifdef __cplusplus
}
#endif
#endif
