/* What ends the program from outside leaves no unfinished file. */
#define _GNU_SOURCE
#include "internal_cli.h"
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

/* The one that writes files; libraries have threads of their own, which a signal may come to. */
static pthread_t main_thread;

static void put(const char *text)
{
    (void)!write(STDERR_FILENO, text, strlen(text));
}

/* As it would have without us: for the shell that waits, and for the core of SIGQUIT. */
static void end_by(int signal_number)
{
    sigset_t one;
    sigemptyset(&one);
    sigaddset(&one, signal_number);
    signal(signal_number, SIG_DFL);
    raise(signal_number);
    pthread_sigmask(SIG_UNBLOCK, &one, NULL);
}

/* Whatever is computed or written is given up at once; what was there before is as it was. */
static void on_signal(int signal_number)
{
    if (!pthread_equal(pthread_self(), main_thread)) {
        pthread_kill(main_thread, signal_number);
        return;
    }
    ff_outputs_remove();
    if (signal_number != SIGINT) end_by(signal_number);
    if (cli_progress_is_shown) put("\r\033[K");
    put("facetfit: cancelled\n");
    _exit(128 + SIGINT);
}

void cli_signals_catch(void)
{
    static const int caught[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU};
    struct sigaction action = {.sa_handler = on_signal}, before;
    sigfillset(&action.sa_mask); /* a second one waits for the first */
    main_thread = pthread_self();
    for (size_t i = 0; i < sizeof caught / sizeof *caught; i++) {
        const int is_ours = sigaction(caught[i], NULL, &before) == 0 && before.sa_handler != SIG_IGN; /* else nohup's */
        if (is_ours) sigaction(caught[i], &action, NULL);
    }
    signal(SIGXFSZ, SIG_IGN); /* a write that goes too far fails with a reason */
}
