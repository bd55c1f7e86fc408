/* Replays samples from standard input: doubles reset, joints, reading; writes solved, offsets, deflection, wrench.
   With -DTIMED: the medians of each call's time and of a peer's, ns, to standard error. */
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

static double since(struct timespec a)
{
    struct timespec b;
    clock_gettime(CLOCK_MONOTONIC, &b);
    return 1e9 * (double)(b.tv_sec - a.tv_sec) + (double)(b.tv_nsec - a.tv_nsec);
}

/* The peer: products of 6 by 6 matrices, each with the result of the one before. */
static double products(int n)
{
    double a[6][6], b[6][6], c[6][6];
    int i, j, k;
    for (i = 0; i < 6; i++) {
        for (j = 0; j < 6; j++) {
            a[i][j] = 0.1 * (i - j) + (i == j);
            b[i][j] = a[j][i];
        }
    }
    while (n-- > 0) {
        for (i = 0; i < 6; i++) {
            for (j = 0; j < 6; j++) {
                double sum = 0.0;
                for (k = 0; k < 6; k++) {
                    sum += a[i][k] * b[k][j];
                }
                c[i][j] = 0.1 * sum;
            }
        }
        memcpy(b, c, sizeof b);
    }
    return b[5][5];
}
#endif

#define L COMPENSATION_JOINTS

int main(void)
{
    static compensation_state state;
    double in[1 + L + 6], out[1 + L + 12];
#ifdef TIMED
    static double times[200000], peers[200000];
    volatile double result;
    size_t n = 0;
    struct timespec a;
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
        if (n < 200000) {
            times[n] = since(a);
            clock_gettime(CLOCK_MONOTONIC, &a);
            result = products(PEER_PRODUCTS);
            peers[n++] = since(a);
            (void)result;
        }
#endif
        memcpy(out + 1 + L, state.deflection, sizeof state.deflection);
        memcpy(out + 7 + L, state.wrench, sizeof state.wrench);
        fwrite(out, sizeof out, 1, stdout);
    }
#ifdef TIMED
    qsort(times, n, sizeof times[0], by_size);
    qsort(peers, n, sizeof peers[0], by_size);
    fprintf(stderr, "%.0f %.0f\n", times[n / 2], peers[n / 2]);
#else
    fprintf(stderr, "%s\n", compensation_model_hash());
#endif
    return 0;
}
