/* Replays samples from standard input: doubles reset, joints, reading; writes solved, offsets, deflection, wrench.
   With an argument: the samples again and again, each call's time in ns, the median to standard error. */
#include "compensation.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef TIMED
#include <time.h>
static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}
#endif

#define L COMPENSATION_JOINTS

int main(void)
{
    static compensation_state state;
    double in[1 + L + 6], out[1 + L + 12];
#ifdef TIMED
    static double times[200000];
    size_t n = 0;
    struct timespec a, b;
#endif
    compensation_reset(&state);
    while (fread(in, sizeof in, 1, stdin) == 1) {
        if (in[0] != 0.0) {
            compensation_reset(&state);
        }
#ifdef TIMED
        clock_gettime(CLOCK_MONOTONIC, &a);
#endif
        out[0] = compensation_step(&state, in + 1, in + 1 + L, out + 1);
#ifdef TIMED
        clock_gettime(CLOCK_MONOTONIC, &b);
        if (n < 200000) {
            times[n++] = 1e9 * (double)(b.tv_sec - a.tv_sec) + (double)(b.tv_nsec - a.tv_nsec);
        }
#endif
        memcpy(out + 1 + L, state.deflection, sizeof state.deflection);
        memcpy(out + 7 + L, state.wrench, sizeof state.wrench);
        fwrite(out, sizeof out, 1, stdout);
    }
#ifdef TIMED
    qsort(times, n, sizeof times[0], by_size);
    fprintf(stderr, "%.0f %.0f\n", times[n / 2], times[n - 1 - n / 1000]);
#else
    fprintf(stderr, "%s\n", compensation_model_hash());
#endif
    return 0;
}
