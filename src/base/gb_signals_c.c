/* Signals that ask a run to stop: the handler only takes note, the run looks between two steps. */
#define _DEFAULT_SOURCE
#include <signal.h>
#include <string.h>
#include <sys/time.h>

static volatile sig_atomic_t caught;

static void take_note(int number)
{
    if (number == SIGINT && caught == SIGINT) {
        /* Whoever interrupts twice does not want to wait: die of it now, as a program without a handler would. */
        signal(SIGINT, SIG_DFL);
        raise(SIGINT);
        return;
    }
    if (caught == 0 || number == SIGINT)
        caught = number;
}

/* From now on a signal is taken note of. System calls that it meets go on. */
static void watch(int number)
{
    struct sigaction action;

    memset(&action, 0, sizeof action);
    action.sa_handler = take_note;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaction(number, &action, NULL);
}

void gb_watch_signals(void)
{
    watch(SIGTERM);
    watch(SIGINT);
    watch(SIGUSR1);
}

/* After so many seconds of wall time there will have been a signal. */
void gb_stop_after(double seconds)
{
    struct itimerval timer = {.it_value = {.tv_sec = (time_t)seconds}};

    timer.it_value.tv_usec = (suseconds_t)(1e6 * (seconds - (double)timer.it_value.tv_sec));
    if (seconds <= 0)
        timer.it_value = (struct timeval){.tv_usec = 1};
    watch(SIGALRM);
    setitimer(ITIMER_REAL, &timer, NULL);
}

/* 0: none so far; 1: SIGTERM, 2: SIGINT, 3: SIGUSR1, 4: the time of gb_stop_after. */
int gb_caught_signal(void)
{
    switch (caught) {
    case SIGTERM:
        return 1;
    case SIGINT:
        return 2;
    case SIGUSR1:
        return 3;
    case SIGALRM:
        return 4;
    default:
        return 0;
    }
}
