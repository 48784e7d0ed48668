/* Threads that take jobs, and what a signal does meanwhile. */
#define _GNU_SOURCE
#include "internal_batch.h"
#include "base/internal_output.h"
#include <malloc.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { STACK = 8 << 20 }; /* that of the command, docs/library.md */

/* ---- signals --------------------------------------------------------------------------------- */

/* Held for reading while something is written that must be whole; whoever ends the program takes it for good. */
static pthread_rwlock_t outputs = PTHREAD_RWLOCK_WRITER_NONRECURSIVE_INITIALIZER_NP;

void batch_hold(void)
{
    pthread_rwlock_rdlock(&outputs);
}

void batch_release(void)
{
    pthread_rwlock_unlock(&outputs);
}

/* 0: all jobs are over. A handler may come at any time and on any thread: it only tells the one that waits. */
static volatile sig_atomic_t came;
static sem_t something_came;

static void tell(int signal_number)
{
    came = signal_number;
    sem_post(&something_came);
}

static const int caught[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU};
enum { CAUGHT = sizeof caught / sizeof *caught };

/* What is being written has most of a second to become whole; then it goes. */
static void end_program(int signal_number)
{
    static const char said[] = "\r\033[Kfacetfit: cancelled\n";
    struct timespec limit;
    clock_gettime(CLOCK_REALTIME, &limit);
    limit.tv_nsec += 700000000;
    limit.tv_sec += limit.tv_nsec / 1000000000;
    limit.tv_nsec %= 1000000000;
    pthread_rwlock_timedwrlock(&outputs, &limit);
    ff_outputs_remove();
    if (signal_number == SIGINT) {
        const size_t terminal_only = isatty(STDERR_FILENO) ? 0 : 4;
        (void)!write(STDERR_FILENO, said + terminal_only, sizeof said - 1 - terminal_only);
        _exit(128 + SIGINT);
    }
    sigset_t one;
    sigemptyset(&one);
    sigaddset(&one, signal_number);
    signal(signal_number, SIG_DFL);
    pthread_sigmask(SIG_UNBLOCK, &one, NULL);
    raise(signal_number);
    _exit(128 + signal_number);
}

static void *watch(void *unused)
{
    while (sem_wait(&something_came) != 0) {
    }
    if (came) end_program(came);
    return unused;
}

/* Those that whoever started us wants to be ignored stay so. */
static void catch_signals(struct sigaction before[CAUGHT])
{
    struct sigaction action = {.sa_handler = tell, .sa_flags = SA_RESTART};
    sigfillset(&action.sa_mask);
    for (size_t k = 0; k < CAUGHT; k++)
        if (sigaction(caught[k], NULL, &before[k]) == 0 && before[k].sa_handler != SIG_IGN) sigaction(caught[k], &action, NULL);
}

static void release_signals(const struct sigaction before[CAUGHT])
{
    for (size_t k = 0; k < CAUGHT; k++) sigaction(caught[k], &before[k], NULL);
}

/* ---- jobs ------------------------------------------------------------------------------------ */

typedef struct work {
    const batch_engine *e;
    pthread_mutex_t mutex;
    size_t next;
    int running, in_use; /* jobs that run, and their threads */
} work;

/* The next job, and how many threads it may have: of those that are free a share of what is left. 0: there is none. */
static int take_job(work *w, size_t *job, int *threads)
{
    pthread_mutex_lock(&w->mutex);
    const int any = w->next < w->e->n && !*w->e->stop;
    if (any) {
        const size_t left = w->e->n - w->next, places = (size_t)(w->e->workers - w->running);
        const int share = (w->e->threads - w->in_use) / (int)(left < places ? left : places);
        *job = w->next++;
        *threads = share > 1 ? share : 1;
        w->in_use += *threads;
        w->running++;
    }
    pthread_mutex_unlock(&w->mutex);
    return any;
}

static void give_back(work *w, int threads)
{
    pthread_mutex_lock(&w->mutex);
    w->in_use -= threads;
    w->running--;
    pthread_mutex_unlock(&w->mutex);
}

static void *take_jobs(void *context)
{
    work *w = context;
    size_t job;
    for (int threads; take_job(w, &job, &threads); give_back(w, threads)) w->e->run(w->e->context, job, threads);
    return NULL;
}

static int start(pthread_t *thread, void *(*function)(void *), void *context)
{
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes)) return 0;
    const int failed = pthread_attr_setstacksize(&attributes, STACK) || pthread_create(thread, &attributes, function, context);
    pthread_attr_destroy(&attributes);
    return !failed;
}

/* What one job gives back the next one takes: without a way through the system, which has to clear every page. */
static void keep_memory(void)
{
    enum { PLANE = 8 << 20, KEPT = 64 << 20 };
    mallopt(M_MMAP_THRESHOLD, PLANE);
    mallopt(M_TRIM_THRESHOLD, KEPT);
    mallopt(M_TOP_PAD, 1 << 20);
}

ff_status batch_engine_run(const batch_engine *e)
{
    struct sigaction before[CAUGHT];
    work w = {.e = e, .mutex = PTHREAD_MUTEX_INITIALIZER};
    const size_t most = e->n < (size_t)e->workers ? e->n : (size_t)e->workers;
    pthread_t watcher, *worker = calloc(most + 1, sizeof *worker);
    size_t n = 0;
    came = 0;
    if (!worker || sem_init(&something_came, 0, 0)) {
        free(worker);
        return FF_ERR_MEMORY;
    }
    if (!start(&watcher, watch, NULL)) {
        free(worker);
        sem_destroy(&something_came);
        return FF_ERR_MEMORY;
    }
    keep_memory();
    catch_signals(before);
    while (n < most && start(&worker[n], take_jobs, &w)) n++;
    for (size_t k = 0; k < n; k++) pthread_join(worker[k], NULL);
    release_signals(before);
    sem_post(&something_came);
    pthread_join(watcher, NULL);
    sem_destroy(&something_came);
    free(worker);
    return n ? FF_OK : FF_ERR_MEMORY;
}
