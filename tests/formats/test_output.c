/* Output files: whole or not at all, and every way in which a disk says no is told. */
#include "check_table.h"
#include "base/internal_output.h"
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

static void fill(FILE *f, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++) putc('x', f);
}

static int exists(const char *path)
{
    struct stat st;
    return lstat(path, &st) == 0;
}

static void commit_and_abort(void)
{
    const char *path = ff_test_path("a.txt");
    ff_output out;
    ff_error err = {0};
    if (!FF_CHECK(ff_output_open(path, &out, &err) == FF_OK, "%s", err.message)) return;
    fputs("new", out.file);
    FF_CHECK(!exists(path) && out.temporary && exists(out.temporary), "the name appeared before commit");
    FF_CHECK(ff_output_commit(&out, &err) == FF_OK, "%s", err.message);
    size_t n;
    char *bytes = ff_test_slurp(path, &n);
    FF_CHECK(strcmp(bytes, "new") == 0, "'%s'", bytes);
    free(bytes);

    FF_CHECK(ff_output_open(path, &out, &err) == FF_OK, "%s", err.message);
    fill(out.file, 200000);
    ff_output_abort(&out);
    ff_output_abort(&out);
    bytes = ff_test_slurp(path, &n);
    FF_CHECK(strcmp(bytes, "new") == 0, "abort changed the old file");
    free(bytes);
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

static void permissions_and_links(void)
{
    const char *path = ff_test_path("mode.txt"), *link_path = ff_test_path("link.txt");
    ff_test_write(path, "old", 3);
    chmod(path, 0640);
    FF_CHECK(symlink(path, link_path) == 0, "symlink");
    ff_output out;
    ff_error err = {0};
    if (!FF_CHECK(ff_output_open(link_path, &out, &err) == FF_OK, "%s", err.message)) return;
    fputs("through the link", out.file);
    FF_CHECK(ff_output_commit(&out, &err) == FF_OK, "%s", err.message);
    struct stat st;
    FF_CHECK(lstat(link_path, &st) == 0 && S_ISLNK(st.st_mode), "the link became a file");
    FF_CHECK(stat(path, &st) == 0 && (st.st_mode & 0777) == 0640 && st.st_size == 16, "mode %o size %ld", st.st_mode & 0777u,
             (long)st.st_size);
    /* two at once on one name: both whole, the last commit wins */
    ff_output other;
    FF_CHECK(ff_output_open(path, &out, &err) == FF_OK && ff_output_open(path, &other, &err) == FF_OK, "%s", err.message);
    fputs("one", out.file);
    fputs("two", other.file);
    FF_CHECK(ff_output_commit(&other, &err) == FF_OK && ff_output_commit(&out, &err) == FF_OK, "%s", err.message);
    size_t n;
    char *bytes = ff_test_slurp(path, &n);
    FF_CHECK(strcmp(bytes, "one") == 0, "'%s'", bytes);
    free(bytes);
}

static void expect_refusal(const char *label, const char *path, const char *word)
{
    ff_output out;
    memset(&out, 0x5A, sizeof out);
    ff_error err = {0};
    ff_status status = ff_output_open(path, &out, &err);
    FF_CHECK(status == FF_ERR_WRITE && strcmp(err.path, path) == 0 && strstr(err.message, word), "%s: %d %s: %s", label, status,
             err.path, err.message);
    if (status == FF_OK) ff_output_abort(&out);
}

static void refusals(void)
{
    expect_refusal("directory", ff_test_dir, "directory");
    expect_refusal("missing directory", ff_test_path("none/x.txt"), "No such file");
    char name[300];
    memset(name, 'n', sizeof name - 1);
    name[sizeof name - 1] = '\0';
    expect_refusal("long name", name, "long");
    expect_refusal("empty name", "", "No such file");
    if (geteuid() != 0) {
        const char *locked = ff_test_path("locked");
        ff_test_write(locked, "x", 1);
        chmod(locked, 0444);
        expect_refusal("read-only file", locked, "ermission");
    }
}

/* A device is written as it is, and says no at the end whatever was buffered before. */
static void full_device(void)
{
    static const size_t sizes[] = {1, 70000, 3000000};
    struct stat before, after;
    if (stat("/dev/full", &before) != 0) {
        printf("no /dev/full here: a full disk is only tried with a size limit\n");
        return;
    }
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        ff_output out;
        ff_error err = {0};
        if (!FF_CHECK(ff_output_open("/dev/full", &out, &err) == FF_OK, "%s", err.message)) return;
        if (!FF_CHECK(out.temporary == NULL, "a device would be replaced by a file")) {
            ff_output_abort(&out); /* before it is: tests may run as root */
            return;
        }
        fill(out.file, sizes[k]);
        ff_status status = ff_output_commit(&out, &err);
        FF_CHECK(status == FF_ERR_WRITE && strstr(err.message, strerror(ENOSPC)), "%zu bytes: %d %s", sizes[k], status,
                 err.message);
    }
    FF_CHECK(stat("/dev/full", &after) == 0 && S_ISCHR(after.st_mode), "/dev/full was replaced");
}

/* The size limit of a process stands for a disk that fills up: in a child, since it stays. */
static int write_beyond_limit(const char *path)
{
    struct rlimit limit = {100000, 100000};
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &limit);
    ff_output out;
    ff_error err = {0};
    if (ff_output_open(path, &out, &err) != FF_OK) return 2;
    fill(out.file, 1000000);
    ff_status status = ff_output_commit(&out, &err);
    return status == FF_ERR_WRITE && strstr(err.message, strerror(EFBIG)) ? 0 : 3;
}

static void disk_that_fills(void)
{
    const char *path = ff_test_path("precious.txt");
    ff_test_write(path, "keep", 4);
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) _exit(write_beyond_limit(path));
    int how = 0;
    waitpid(child, &how, 0);
    FF_CHECK(WIFEXITED(how) && WEXITSTATUS(how) == 0, "child ended with %d", WEXITSTATUS(how));
    size_t n;
    char *bytes = ff_test_slurp(path, &n);
    FF_CHECK(strcmp(bytes, "keep") == 0, "the old file was lost");
    free(bytes);
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

/* "-" goes after what the program printed itself, and a full standard output is told. */
static void test_stdout(void)
{
    const char *path = ff_test_path("stdout.txt");
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        ff_output out;
        ff_error err = {0};
        if (!freopen(path, "w", stdout)) _exit(1);
        printf("first ");
        if (ff_output_open("-", &out, &err) != FF_OK) _exit(2);
        fputs("second ", out.file);
        if (ff_output_commit(&out, &err) != FF_OK) _exit(3);
        printf("third");
        fflush(stdout);
        if (!freopen("/dev/full", "w", stdout)) _exit(0);
        if (ff_output_open("-", &out, &err) != FF_OK) _exit(4);
        fputs("lost", out.file);
        _exit(ff_output_commit(&out, &err) == FF_ERR_WRITE && strcmp(err.path, "-") == 0 ? 0 : 5);
    }
    int how = 0;
    waitpid(child, &how, 0);
    FF_CHECK(WIFEXITED(how) && WEXITSTATUS(how) == 0, "child ended with %d", WEXITSTATUS(how));
    size_t n;
    char *bytes = ff_test_slurp(path, &n);
    FF_CHECK(strcmp(bytes, "first second third") == 0, "'%s'", bytes);
    free(bytes);
}

FF_TEST_MAIN(FF_TEST(commit_and_abort), FF_TEST(permissions_and_links), FF_TEST(refusals), FF_TEST(full_device),
             FF_TEST(disk_that_fills), FF_TEST(test_stdout))
