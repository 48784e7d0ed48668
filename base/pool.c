/* A pool of threads that share out numbered items. */
#define _GNU_SOURCE /* sysconf(_SC_NPROCESSORS_ONLN) and cpu affinity */
#include "internal_pool.h"
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>

enum { THREADS_MOST = 1024, STACK = 1 << 20 };

struct ff_pool {
    int threads;       /* that really run, the caller's included */
    pthread_t *handle; /* [threads - 1]                          */
    pthread_mutex_t mutex;
    pthread_cond_t wake, done;
    unsigned round; /* counts the calls of run: a worker sleeps until it changes */
    int busy;       /* workers still in this round                               */
    int quit;
    size_t n;
    atomic_size_t next;
    void (*fn)(void *, size_t, int);
    void *context;
};

typedef struct worker_start {
    ff_pool *pool;
    int worker;
} worker_start;

static void take_items(ff_pool *pool, int worker)
{
    for (size_t i; (i = atomic_fetch_add(&pool->next, 1)) < pool->n;) pool->fn(pool->context, i, worker);
}

static void *work(void *argument)
{
    const worker_start start = *(worker_start *)argument;
    ff_pool *pool = start.pool;
    free(argument);
    unsigned seen = 0;
    pthread_mutex_lock(&pool->mutex);
    for (;;) {
        while (pool->round == seen && !pool->quit) pthread_cond_wait(&pool->wake, &pool->mutex);
        if (pool->quit) break;
        seen = pool->round;
        pthread_mutex_unlock(&pool->mutex);
        take_items(pool, start.worker);
        pthread_mutex_lock(&pool->mutex);
        if (--pool->busy == 0) pthread_cond_signal(&pool->done);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

/* With a stack of its own size: the system's usual one is that of the limit of the process, or of the C library, and may be less
 * than the library needs (docs/library.md), or so much that a thousand threads of it are not to be had. */
static int create(pthread_t *thread, void *start)
{
    pthread_attr_t attributes;
    int failed = pthread_attr_init(&attributes);
    if (failed) return failed;
    failed = pthread_attr_setstacksize(&attributes, STACK);
    if (!failed) failed = pthread_create(thread, &attributes, work, start);
    pthread_attr_destroy(&attributes);
    return failed;
}

/* Signals are the business of the caller's thread. */
static int start_worker(ff_pool *pool, int worker)
{
    worker_start *start = malloc(sizeof *start);
    if (!start) return -1;
    *start = (worker_start){pool, worker};
    sigset_t all, old;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old);
    const int failed = create(&pool->handle[worker - 1], start);
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    if (failed) free(start);
    return failed;
}

ff_pool *ff_pool_new(int threads)
{
    if (threads > THREADS_MOST) threads = THREADS_MOST;
    ff_pool *pool = calloc(1, sizeof *pool);
    if (!pool) return NULL;
    pool->threads = 1;
    pool->handle = calloc((size_t)(threads > 1 ? threads - 1 : 1), sizeof *pool->handle);
    if (!pool->handle) {
        free(pool);
        return NULL;
    }
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->done, NULL);
    while (pool->threads < threads && start_worker(pool, pool->threads) == 0) pool->threads++;
    return pool;
}

void ff_pool_free(ff_pool *pool)
{
    if (!pool) return;
    pthread_mutex_lock(&pool->mutex);
    pool->quit = 1;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->mutex);
    for (int i = 1; i < pool->threads; i++) pthread_join(pool->handle[i - 1], NULL);
    pthread_cond_destroy(&pool->done);
    pthread_cond_destroy(&pool->wake);
    pthread_mutex_destroy(&pool->mutex);
    free(pool->handle);
    free(pool);
}

int ff_pool_threads(const ff_pool *pool)
{
    return pool->threads;
}

void ff_pool_run(ff_pool *pool, size_t n, void (*fn)(void *, size_t, int), void *context)
{
    pool->n = n;
    pool->fn = fn;
    pool->context = context;
    atomic_store(&pool->next, 0);
    const int helped = pool->threads > 1 && n > 1;
    if (helped) {
        pthread_mutex_lock(&pool->mutex);
        pool->busy = pool->threads - 1;
        pool->round++;
        pthread_cond_broadcast(&pool->wake);
        pthread_mutex_unlock(&pool->mutex);
    }
    take_items(pool, 0);
    if (!helped) return;
    pthread_mutex_lock(&pool->mutex);
    while (pool->busy) pthread_cond_wait(&pool->done, &pool->mutex);
    pthread_mutex_unlock(&pool->mutex);
}

int ff_threads_default(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set) > 0 ? CPU_COUNT(&set) : 1;
    return 1;
}
