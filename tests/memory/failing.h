/* Allocations that fail when they are told to. These definitions stand before the C library's for the program and every library
 * that it loads; what glibc has beneath them does the work. */
#ifndef FF_TEST_FAILING_H
#define FF_TEST_FAILING_H
#include <errno.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t n, size_t size);
extern void *__libc_realloc(void *p, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);
extern void __libc_free(void *p);

static atomic_long failing_count, failing_live, failing_refused;
static atomic_long failing_at = -1;   /* the number of the one that fails; -1: none */
static atomic_int failing_on;         /* 1: so do all after it */
static void (*failing_noticed)(void); /* called where one fails; NULL: nothing */

/* Begins to count from 0. */
static void failing_begin(long at, int and_all_after)
{
    atomic_store(&failing_count, 0);
    atomic_store(&failing_refused, 0);
    atomic_store(&failing_on, and_all_after);
    atomic_store(&failing_at, at);
}

static int refused(void)
{
    const long here = atomic_fetch_add(&failing_count, 1), at = atomic_load(&failing_at);
    const int no = at >= 0 && (here == at || (here > at && atomic_load(&failing_on)));
    if (!no) return 0;
    atomic_fetch_add(&failing_refused, 1);
    if (failing_noticed) failing_noticed();
    errno = ENOMEM;
    return 1;
}

static void *counted(void *p)
{
    if (p) atomic_fetch_add(&failing_live, 1);
    return p;
}

void *malloc(size_t size)
{
    return refused() ? NULL : counted(__libc_malloc(size));
}

void *calloc(size_t n, size_t size)
{
    return refused() ? NULL : counted(__libc_calloc(n, size));
}

void *realloc(void *p, size_t size)
{
    if (refused()) return NULL;
    void *larger = __libc_realloc(p, size);
    return p ? larger : counted(larger);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    return refused() ? NULL : counted(__libc_memalign(alignment, size));
}

void *memalign(size_t alignment, size_t size)
{
    return refused() ? NULL : counted(__libc_memalign(alignment, size));
}

int posix_memalign(void **out, size_t alignment, size_t size)
{
    void *p = refused() ? NULL : counted(__libc_memalign(alignment, size));
    if (p) *out = p;
    return p ? 0 : ENOMEM;
}

void free(void *p)
{
    if (p) atomic_fetch_sub(&failing_live, 1);
    const int reason = errno;
    __libc_free(p);
    errno = reason;
}

void *mmap(void *address, size_t size, int protection, int flags, int fd, off_t offset)
{
    const int is_memory = (flags & MAP_ANONYMOUS) != 0;
    if (is_memory && refused()) return MAP_FAILED;
    void *p = (void *)syscall(SYS_mmap, address, size, protection, flags, fd, offset);
    if (p != MAP_FAILED) atomic_fetch_add(&failing_live, 1);
    return p;
}

int munmap(void *address, size_t size)
{
    const int status = (int)syscall(SYS_munmap, address, size);
    if (!status) atomic_fetch_sub(&failing_live, 1);
    return status;
}
#endif
