/* A request to stop, from a signal: noted, and looked at where the program can stop in good order. */
#define _POSIX_C_SOURCE 200809L
#include <signal.h>
#include <stddef.h>
#include <string.h>

static volatile sig_atomic_t asked;

static void note(int signal_number)
{
    asked = signal_number;
}

/* From now on SIGTERM, SIGINT and SIGUSR1 ask the program to stop in place of ending it. */
void gb_listen_for_stop(void)
{
    const int signals[] = {SIGTERM, SIGINT, SIGUSR1};
    struct sigaction action;

    memset(&action, 0, sizeof action);
    action.sa_handler = note;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++)
        sigaction(signals[i], &action, NULL);
}

/* The number of the signal that has asked, or 0. */
int gb_stop_signal(void)
{
    return asked;
}
