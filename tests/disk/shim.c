/* A disk that fails, or loses power: loaded before the C library (LD_PRELOAD), it counts what is done to files that are written.
 *
 *   DISK_COUNT=FILE       writes how many such calls there were, and a line with the first letter of each: o w t f c r
 *   DISK_FAIL=N:ERRNO     the Nth fails with this number, and all like it after it (a full disk stays full)
 *   DISK_CRASH=N          before the Nth, or at the end of the process, the power goes: what was not synced is forgotten, and the
 *                         process ends with 77
 *
 *   DISK_SIGNAL=N:NUMBER  before the Nth, or at the end of the process, this signal comes
 *
 * Counted are open (of a file that is created), write, ftruncate, fsync, close, rename. A stream of a descriptor (fdopen) is one
 * whose writes come by here, since those of the C library itself do not. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MOST = 64, MOST_CALLS = 4096 };
typedef enum call { OPEN, WRITE, TRUNCATE, SYNC, CLOSE, RENAME } call;

static struct written {
    int fd, kept; /* kept: a second descriptor of the file, to forget by */
    FILE *stream;
    off_t synced;
    int folder;
} file[MOST];
static int n_files, count, failing = -1;
static char letters[MOST_CALLS + 1];

static void *real(const char *name)
{
    return dlsym(RTLD_NEXT, name);
}

static struct written *of(int fd)
{
    for (int k = n_files - 1; k >= 0; k--)
        if (file[k].fd == fd) return &file[k];
    return NULL;
}

static void lose_power(void)
{
    static int (*truncate_real)(int, off_t);
    if (!truncate_real) truncate_real = (int (*)(int, off_t))real("ftruncate");
    for (int k = 0; k < n_files; k++) {
        struct stat s;
        if (file[k].kept >= 0 && !fstat(file[k].kept, &s) && s.st_size > file[k].synced &&
            truncate_real(file[k].kept, file[k].synced))
            _exit(78);
    }
    _exit(77);
}

static void send_signal(int here)
{
    const char *when = getenv("DISK_SIGNAL"), *number = when ? strchr(when, ':') : NULL;
    if (number && here == atoi(when)) raise(atoi(number + 1));
}

/* Does this one fail? */
static int comes_to_nothing(call c)
{
    const char *crash = getenv("DISK_CRASH"), *fail = getenv("DISK_FAIL");
    if (count < MOST_CALLS) letters[count] = "owtfcr"[c];
    count++;
    send_signal(count);
    if (crash && count == atoi(crash)) lose_power();
    if (!fail) return 0;
    const char *number = strchr(fail, ':');
    if (count == atoi(fail)) failing = (int)c;
    if (failing != (int)c) return 0;
    errno = number ? atoi(number + 1) : EIO;
    return 1;
}

__attribute__((destructor)) static void tell(void)
{
    const char *path = getenv("DISK_COUNT"), *crash = getenv("DISK_CRASH");
    if (crash && atoi(crash) == count + 1) lose_power();
    send_signal(count + 1);
    if (!path) return;
    int (*open_real)(const char *, int, ...) = (int (*)(const char *, int, ...))real("open");
    const int fd = open_real(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    char text[MOST_CALLS + 32];
    const int n = snprintf(text, sizeof text, "%d\n%s\n", count, letters);
    ssize_t (*write_real)(int, const void *, size_t) = (ssize_t(*)(int, const void *, size_t))real("write");
    if (fd < 0 || write_real(fd, text, (size_t)n) != n) _exit(79);
}

static int open_by(const char *name, const char *path, int flags, mode_t mode)
{
    int (*open_real)(const char *, int, ...) = (int (*)(const char *, int, ...))real(name);
    if (!(flags & O_CREAT)) return open_real(path, flags, mode);
    if (comes_to_nothing(OPEN)) return -1;
    const int fd = open_real(path, flags, mode);
    if (fd >= 0 && n_files < MOST) file[n_files++] = (struct written){.fd = fd, .kept = fcntl(fd, F_DUPFD_CLOEXEC, 200)};
    return fd;
}

int open(const char *path, int flags, ...)
{
    va_list more;
    va_start(more, flags);
    const mode_t mode = flags & O_CREAT ? (mode_t)va_arg(more, int) : 0;
    va_end(more);
    return open_by("open", path, flags, mode);
}

int open64(const char *path, int flags, ...)
{
    va_list more;
    va_start(more, flags);
    const mode_t mode = flags & O_CREAT ? (mode_t)va_arg(more, int) : 0;
    va_end(more);
    return open_by("open64", path, flags, mode);
}

ssize_t write(int fd, const void *bytes, size_t n)
{
    ssize_t (*write_real)(int, const void *, size_t) = (ssize_t(*)(int, const void *, size_t))real("write");
    return of(fd) && comes_to_nothing(WRITE) ? -1 : write_real(fd, bytes, n);
}

int ftruncate(int fd, off_t n)
{
    int (*truncate_real)(int, off_t) = (int (*)(int, off_t))real("ftruncate");
    return of(fd) && comes_to_nothing(TRUNCATE) ? -1 : truncate_real(fd, n);
}

int fsync(int fd)
{
    int (*sync_real)(int) = (int (*)(int))real("fsync");
    struct stat s;
    if (comes_to_nothing(SYNC)) return -1;
    const int result = sync_real(fd);
    struct written *w = of(fd);
    if (w && !result && !fstat(fd, &s)) w->synced = s.st_size;
    return result;
}

int close(int fd)
{
    int (*close_real)(int) = (int (*)(int))real("close");
    struct written *w = of(fd);
    if (!w) return close_real(fd);
    const int fails = comes_to_nothing(CLOSE), reason = errno;
    w->fd = -1;
    const int result = close_real(fd); /* a descriptor is gone even where its close fails */
    if (!fails) return result;
    errno = reason;
    return -1;
}

int rename(const char *from, const char *to)
{
    int (*rename_real)(const char *, const char *) = (int (*)(const char *, const char *))real("rename");
    return comes_to_nothing(RENAME) ? -1 : rename_real(from, to);
}

/* ---- streams ----------------------------------------------------------------------------------- */

static ssize_t put(void *cookie, const char *bytes, size_t n)
{
    const ssize_t written = write(((struct written *)cookie)->fd, bytes, n);
    return written < 0 ? 0 : written; /* of a cookie 0 is the error */
}

static int done(void *cookie)
{
    struct written *w = cookie;
    w->stream = NULL;
    return close(w->fd);
}

FILE *fdopen(int fd, const char *mode)
{
    FILE *(*fdopen_real)(int, const char *) = (FILE * (*)(int, const char *)) real("fdopen");
    struct written *w = of(fd);
    if (!w) return fdopen_real(fd, mode);
    w->stream = fopencookie(w, mode, (cookie_io_functions_t){.write = put, .close = done});
    return w->stream;
}

int fileno(FILE *stream)
{
    int (*fileno_real)(FILE *) = (int (*)(FILE *))real("fileno");
    for (int k = 0; k < n_files; k++)
        if (file[k].stream == stream) return file[k].fd;
    return fileno_real(stream);
}
