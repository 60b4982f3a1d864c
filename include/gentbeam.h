/* gentbeam: large, fast motions of soft beams. Runs decks and hands the results out as arrays, without files.
 *
 *     gentbeam_result *r = gentbeam_run_file("cantilever.inp", 1, (const char *[]){"jm=0.5"});
 *     if (gentbeam_status(r) == GENTBEAM_OK) {
 *         int rank;
 *         size_t shape[GENTBEAM_MAX_RANK];
 *         const double *tip = gentbeam_array(r, "transient/probes/tip", &rank, shape);
 *         printf("%zu steps, last %g\n", shape[0] - 1, tip[shape[0] - 1]);
 *     } else {
 *         fputs(gentbeam_message(r), stderr);
 *     }
 *     gentbeam_free(r);
 *
 * Names of arrays are those of the datasets in a results file (docs/results.md), and so are their shapes: the first
 * index runs slowest. OUTPUT chooses what is kept, as for the file. Nothing is written and nothing is printed.
 * One run at a time: the functions that run a deck are not to be called by two threads at once. */
#ifndef GENTBEAM_H
#define GENTBEAM_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GENTBEAM_MAX_RANK 4

/* Exit statuses of the program. */
enum {
    GENTBEAM_OK = 0,
    GENTBEAM_DECK_WRONG = 1,      /* nothing was run */
    GENTBEAM_SOLUTION_FAILED = 2, /* the arrays hold all steps before */
    GENTBEAM_FILE_TROUBLE = 3     /* the deck, or a file it names, cannot be read */
};

typedef struct gentbeam_result gentbeam_result;

/* "0.1.0" */
const char *gentbeam_version(void);

/* Run the deck in a file, or one given as text. `set` holds n_set texts "name=value", which replace values of
 * PARAMETER as the option --set does. The result is never NULL, and is freed by gentbeam_free. */
gentbeam_result *gentbeam_run_file(const char *path, int n_set, const char *const set[]);
gentbeam_result *gentbeam_run_text(const char *text, int n_set, const char *const set[]);

/* How it went, and why not: the diagnostics of a wrong deck, or what failed, where and when. */
int gentbeam_status(const gentbeam_result *result);
const char *gentbeam_message(const gentbeam_result *result);

/* A text about the run: "commands" (names, separated by blanks), "<command>/kind", "<command>/scheme", "title",
 * "units/length", "units/force", "units/time", "parameters" (lines name=value). NULL where there is none. */
const char *gentbeam_text(const gentbeam_result *result, const char *key);

/* The arrays: how many, their names (number from 0), and one by its name. NULL where there is none of that name
 * (rank 0) or it is empty. What is handed out is valid until gentbeam_free. */
int gentbeam_count(const gentbeam_result *result);
const char *gentbeam_name(const gentbeam_result *result, int number);
const double *gentbeam_array(const gentbeam_result *result, const char *name, int *rank,
                             size_t shape[GENTBEAM_MAX_RANK]);

void gentbeam_free(gentbeam_result *result);

#ifdef __cplusplus
}
#endif

#endif
