/** @file internal_pool.h  A pool of threads that share out numbered items. A pool belongs to one thread at a time. */
#ifndef FF_INTERNAL_POOL_H
#define FF_INTERNAL_POOL_H
#include <stddef.h>

typedef struct ff_pool ff_pool;

/** threads >= 1, of which the caller's is one. NULL when out of memory; fewer threads than asked for are not an error. */
ff_pool *ff_pool_new(int threads);
void ff_pool_free(ff_pool *pool);
int ff_pool_threads(const ff_pool *pool);

/** Calls fn(context, item, worker) for item = 0 .. n-1, each once, in any order; worker in [0, threads). Returns when all are done.
 */
void ff_pool_run(ff_pool *pool, size_t n, void (*fn)(void *context, size_t item, int worker), void *context);

/** Threads that the system lets this process run at once, at least 1. */
int ff_threads_default(void);
#endif
