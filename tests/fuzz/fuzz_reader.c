/* What every fuzzer and the replay of the corpora do with one input. */
#define _GNU_SOURCE
#include "fuzz_reader.h"
#include "sound_table.h"
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static void fail(const char *format, const char *what)
{
    fprintf(stderr, "fuzz_reader: %s: %s\n", format, what);
    abort();
}

/* Bytes of a whole file where it has but one size, else 0. Inputs of one short length stand for such a file that goes on with
 * zeros: the corpus stays small, and most executions fast. */
static size_t whole_size(const char *format, size_t size)
{
    return strcmp(format, "merl") == 0 && size == 20 ? 34992012 : strcmp(format, "utia") == 0 && size == 24 ? 1990656 : 0;
}

/* A file in memory with these bytes; its path. */
static const char *memory_file(const char *format, const uint8_t *data, size_t size)
{
    static char path[64];
    static int fd = -1;
    if (fd < 0) fd = memfd_create("input", MFD_CLOEXEC);
    if (fd < 0 || ftruncate(fd, 0) != 0 || pwrite(fd, data, size, 0) != (ssize_t)size) fail(format, "no file in memory");
    const size_t whole = whole_size(format, size);
    if (whole > size && ftruncate(fd, (off_t)whole) != 0) fail(format, "no file in memory");
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    return path;
}

static void write_file(const char *format, const char *folder, const char *name, const void *data, size_t size)
{
    char path[64];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    const int fd = open(path, O_CREAT | O_TRUNC | O_WRONLY, 0600);
    if (fd < 0 || write(fd, data, size) != (ssize_t)size) fail(format, "no file");
    close(fd);
}

/* An image stack needs a folder: one with a picture of four by two pixels. An input that begins with a zero byte is itself a
 * picture, of a stack of one. */
static const char *stack_file(const char *format, const uint8_t *data, size_t size)
{
    static const char picture[] =
        "P6 4 2 255\n\x10\x20\x30\x40\x50\x60\x70\x80\x90\xa0\xb0\xc0\xd0\xe0\xf0\xff\x11\x22\x33\x44\x55\x66\x77"
        "\x88";
    static const char stack[] = "# encoding: linear\nimage,theta_i,phi_i,theta_o,phi_o\np.ppm,30,0,30,180\n";
    static char folder[32], path[64];
    const int is_picture = size > 0 && data[0] == 0;
    if (!folder[0]) {
        strcpy(folder, "/tmp/ff-fuzz-XXXXXX");
        if (!mkdtemp(folder)) fail(format, "no folder");
        snprintf(path, sizeof path, "%s/input.csv", folder);
    }
    if (is_picture) {
        write_file(format, folder, "p.ppm", data + 1, size - 1);
        write_file(format, folder, "input.csv", stack, sizeof stack - 1);
    } else {
        write_file(format, folder, "p.ppm", picture, sizeof picture - 1);
        write_file(format, folder, "input.csv", data, size);
    }
    return path;
}

static void check_error(const char *format, ff_status status, const ff_error *err, const char *path)
{
    if (err->code != status) fail(format, "the error has another code than the call");
    if (status == FF_ERR_INTERNAL) fail(format, err->message);
    if (strncmp(err->message, "image stacks need the module", 28) == 0) fail(format, err->message); /* then nothing is tested */
    if (!err->message[0]) fail(format, "an error without a message");
    if (strcmp(err->path, path)) fail(format, "an error that does not name the file");
}

int fuzz_reader(const char *format, const uint8_t *data, size_t size)
{
    const char *path = strcmp(format, "images") ? memory_file(format, data, size) : stack_file(format, data, size);
    ff_read_options o;
    ff_table t;
    ff_error err = {0};
    const ff_format *f = NULL;
    (void)ff_format_detect(path, &f, &err);
    ff_read_options_init(&o);
    o.format = format;
    if (strcmp(format, "pgii") == 0) o.scale = 2; /* raw currents are refused without one */
    memset(&t, 0x5A, sizeof t);
    err = (ff_error){0};
    const ff_status status = ff_table_read_with_into(path, &o, &t, &err);
    if (status != FF_OK) {
        check_error(format, status, &err, path);
        return 0;
    }
    const char *why = unsound_table(&t, format);
    if (why) fail(format, why);
    f = ff_format_find(format);
    if (f->write && t.n < 1000000 && f->write("/dev/null", &t, NULL, &err) != FF_OK && err.code != FF_ERR_UNSUPPORTED &&
        err.code != FF_ERR_DATA)
        fail(format, err.message);
    ff_table_clear(&t);
    return 1;
}
