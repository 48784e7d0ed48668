/* Output files: whole or not at all, and every way in which a disk says no is told. */
#include "check_table.h"
#include "base/internal_output.h"
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <limits.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>

/* Stands before the C library's, and counts the folders. */
static int synced_folders;

int fsync(int fd)
{
    struct stat st;
    synced_folders += fstat(fd, &st) == 0 && S_ISDIR(st.st_mode);
    return (int)syscall(SYS_fsync, fd);
}

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

static mode_t mode_of(const char *path)
{
    struct stat st;
    return lstat(path, &st) == 0 ? st.st_mode & 07777 : (mode_t)-1;
}

/* Writes `path` and looks at the permissions before and after. */
static void check_modes(const char *label, const char *path, mode_t after)
{
    ff_output out;
    ff_error err = {0};
    if (!FF_CHECK(ff_output_open(path, &out, &err) == FF_OK, "%s: %s", label, err.message)) return;
    fputs("x", out.file);
    fflush(out.file);
    FF_CHECK(mode_of(out.temporary) == 0600, "%s: unfinished, its mode is %o", label, (unsigned)mode_of(out.temporary));
    FF_CHECK(ff_output_commit(&out, &err) == FF_OK, "%s: %s", label, err.message);
    FF_CHECK(mode_of(path) == after, "%s: mode %o, expected %o", label, (unsigned)mode_of(path), (unsigned)after);
}

/* An unfinished file is its owner's alone, under every umask; then it has what the umask leaves, or what the old one had. */
static void modes(void)
{
    static const mode_t masks[] = {0, 022, 027, 077}, old[] = {0600, 0644, 0666, 0755, 0660};
    const char *path = ff_test_path("modes.txt");
    const mode_t before = umask(0);
    for (size_t k = 0; k < sizeof masks / sizeof *masks; k++) {
        umask(masks[k]);
        unlink(path);
        check_modes("new", path, 0666 & ~masks[k]);
        for (size_t i = 0; i < sizeof old / sizeof *old; i++) {
            chmod(path, old[i]);
            check_modes("old", path, old[i]);
        }
        FF_CHECK(umask(masks[k]) == masks[k], "the umask was changed");
    }
    umask(before);
    chmod(path, 06755);
    check_modes("setuid", path, 0755);
    chmod(path, 01644);
    check_modes("sticky", path, 0644);
}

/* As the one who may: the file stays its owner's and its group's. */
static void owner(void)
{
    const char *path = ff_test_path("owner.txt");
    struct stat st;
    if (geteuid() != 0) FF_SKIP("only root may give files away\n");
    ff_test_write(path, "x", 1);
    if (!FF_CHECK(chown(path, 12345, 54321) == 0 && chmod(path, 0640) == 0, "chown")) return;
    check_modes("another's", path, 0640);
    FF_CHECK(stat(path, &st) == 0 && st.st_uid == 12345 && st.st_gid == 54321, "%ld:%ld", (long)st.st_uid, (long)st.st_gid);
}

/* Whose group cannot be kept: ours may no more than everyone. In a child, which gives up its rights. */
static void group(void)
{
    const char *path = ff_test_path("group.txt");
    if (geteuid() != 0) FF_SKIP("only root may take another group\n");
    ff_test_write(path, "x", 1);
    if (!FF_CHECK(chown(path, 12345, 54321) == 0 && chmod(path, 0664) == 0 && chmod(ff_test_dir, 0777) == 0, "chown")) return;
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        ff_output out;
        ff_error err = {0};
        if (setgid(777) || setuid(12345) || ff_output_open(path, &out, &err) != FF_OK) _exit(1);
        _exit(ff_output_commit(&out, &err) == FF_OK ? 0 : 2);
    }
    int how = 0;
    waitpid(child, &how, 0);
    FF_CHECK(WIFEXITED(how) && WEXITSTATUS(how) == 0, "child ended with %d", how);
    FF_CHECK(mode_of(path) == 0644, "mode %o", (unsigned)mode_of(path));
}

/* A link to nowhere stays one, and leads to the new file, whether it says so from the root or from where it lies. */
static void dangling_links(void)
{
    const char *names[][2] = {{"nowhere.txt", "relative.link"}, {ff_test_path("absent.txt"), "absolute.link"}};
    for (int k = 0; k < 2; k++) {
        const char *link_path = ff_test_path(names[k][1]), *first = ff_test_path(k ? "first.link" : "second.link");
        struct stat st;
        ff_output out;
        ff_error err = {0};
        FF_CHECK(symlink(names[k][0], link_path) == 0 && symlink(names[k][1], first) == 0, "symlink");
        if (!FF_CHECK(ff_output_open(first, &out, &err) == FF_OK, "%s", err.message)) continue;
        fputs("there", out.file);
        FF_CHECK(ff_output_commit(&out, &err) == FF_OK, "%s", err.message);
        FF_CHECK(lstat(link_path, &st) == 0 && S_ISLNK(st.st_mode), "the link became a file");
        FF_CHECK(lstat(first, &st) == 0 && S_ISLNK(st.st_mode), "the first link became a file");
        FF_CHECK(stat(first, &st) == 0 && st.st_size == 5, "it leads nowhere");
        const char *found = ff_test_path(k ? "absent.txt" : "nowhere.txt");
        FF_CHECK(lstat(found, &st) == 0 && S_ISREG(st.st_mode), "%s is not there", found);
    }
}

/* Names as long as the system lets them be, whole paths and last parts. */
static void long_names(void)
{
    char name[NAME_MAX + 1], path[PATH_MAX];
    for (size_t length = NAME_MAX - 40; length <= NAME_MAX; length++) {
        memset(name, 'n', length);
        name[length] = '\0';
        ff_output out;
        ff_error err = {0};
        snprintf(path, sizeof path, "%s/%s", ff_test_dir, name);
        if (!FF_CHECK(ff_output_open(path, &out, &err) == FF_OK, "%zu bytes: %s", length, err.message)) continue;
        FF_CHECK(ff_output_commit(&out, &err) == FF_OK && exists(path), "%zu bytes: %s", length, err.message);
    }
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

/* The new name survives a power cut only when the folder is written too. */
static void folder_is_synced(void)
{
    static const char *const names[] = {"a.txt", "sub/b.txt"};
    ff_error err = {0};
    char before[PATH_MAX];
    if (!FF_CHECK(getcwd(before, sizeof before) && mkdir(ff_test_path("sub"), 0777) == 0 && chdir(ff_test_dir) == 0, "chdir"))
        return;
    for (size_t k = 0; k < 2; k++) {
        ff_output out;
        synced_folders = 0;
        if (!FF_CHECK(ff_output_open(names[k], &out, &err) == FF_OK, "%s", err.message)) continue;
        FF_CHECK(ff_output_commit(&out, &err) == FF_OK, "%s", err.message);
        FF_CHECK(synced_folders == 1, "%s: %d folders were synchronised", names[k], synced_folders);
    }
    FF_CHECK(chdir(before) == 0, "chdir");
}

/* Opened, written and handed over. */
static void hand_over(ff_outputs *all, const char *path)
{
    ff_output out;
    ff_error err = {0};
    if (!FF_CHECK(ff_output_open_with(path, all, &out, &err) == FF_OK, "%s", err.message)) return;
    fputs("new", out.file);
    FF_CHECK(ff_output_commit(&out, &err) == FF_OK, "%s: %s", path, err.message);
    FF_CHECK(!out.file && !out.temporary, "%s: was not handed over", path);
}

static void together(void)
{
    const char *one = ff_test_path("one.txt"), *two = ff_test_path("two.txt");
    ff_outputs all = {0};
    ff_error err = {0};
    hand_over(&all, one);
    hand_over(&all, "/dev/full");
    hand_over(&all, two);
    FF_CHECK(!exists(one) && !exists(two) && check_leftovers() == 2, "a name appeared before its time");
    FF_CHECK(ff_outputs_commit(&all, &err) == FF_ERR_WRITE && !strcmp(err.path, "/dev/full"), "%s: %s", err.path, err.message);
    FF_CHECK(!exists(one) && !exists(two) && check_leftovers() == 0 && all.n == 0, "a full device left an output");
    hand_over(&all, one);
    ff_outputs_abort(&all);
    FF_CHECK(!exists(one) && check_leftovers() == 0 && all.n == 0, "what was dropped is there");
    FF_CHECK(ff_outputs_commit(&all, &err) == FF_OK, "none is not nothing to do");
    for (int k = 0; k <= FF_OUTPUTS_MOST; k++) {
        ff_output out;
        char name[16];
        snprintf(name, sizeof name, "m%d", k);
        FF_CHECK(ff_output_open_with(ff_test_path(name), &all, &out, &err) == FF_OK, "%s", err.message);
        FF_CHECK(ff_output_commit(&out, &err) == (k < FF_OUTPUTS_MOST ? FF_OK : FF_ERR_INTERNAL), "output %d: %s", k, err.message);
    }
    FF_CHECK(ff_outputs_commit(&all, &err) == FF_OK && exists(ff_test_path("m7")) && check_leftovers() == 0, "%s", err.message);
}

/* Of those that have their names already the error knows. */
static void name_that_cannot_be_given(void)
{
    const char *one = ff_test_path("first.txt"), *two = ff_test_path("second.txt"), *three = ff_test_path("third.txt");
    ff_outputs all = {0};
    ff_error err = {0};
    hand_over(&all, one);
    hand_over(&all, two);
    hand_over(&all, three);
    FF_CHECK(mkdir(two, 0700) == 0, "%s", two);
    FF_CHECK(ff_outputs_commit(&all, &err) == FF_ERR_WRITE && !strcmp(err.path, two), "%s: %s", err.path, err.message);
    FF_CHECK(strstr(err.message, "in place already: ") && strstr(err.message, one), "%s", err.message);
    FF_CHECK(exists(one) && !exists(three) && check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

/* What a handler does: the unfinished files go, and those that were finished or dropped do not matter. */
static void removed_by_signal(void)
{
    ff_output out[3];
    ff_error err = {0};
    for (int k = 0; k < 3; k++)
        if (!FF_CHECK(ff_output_open(ff_test_path(k ? k == 1 ? "s1" : "s2" : "s0"), &out[k], &err) == FF_OK, "%s", err.message))
            return;
    ff_output_abort(&out[1]);
    FF_CHECK(check_leftovers() == 2, "%d unfinished files", check_leftovers());
    ff_outputs_remove();
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
    FF_CHECK(ff_output_commit(&out[0], &err) == FF_ERR_WRITE, "a file that is gone was finished");
    ff_output_abort(&out[2]);
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
    expect_refusal("missing directory", ff_test_path("none/x.txt"), "none does not exist");
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

FF_TEST_MAIN(FF_TEST(commit_and_abort), FF_TEST(permissions_and_links), FF_TEST(modes), FF_TEST(owner), FF_TEST(group),
             FF_TEST(dangling_links), FF_TEST(long_names), FF_TEST(folder_is_synced), FF_TEST(together),
             FF_TEST(name_that_cannot_be_given), FF_TEST(removed_by_signal), FF_TEST(refusals), FF_TEST(full_device),
             FF_TEST(disk_that_fills), FF_TEST(test_stdout))
