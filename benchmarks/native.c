/* SPDX-License-Identifier: BSD-3-Clause
 *
 * Seconds of processor time of n calls of a compiled right-hand side. The kernel is reached through a pointer and x[0] moves
 * by 1e-10 between calls, so no call can be left out or taken out of the loop.
 */
#include <time.h>

typedef void (*program_fn)(double, const double *, const double *, const double *, const double *, double *);
typedef void (*lanes_fn)(const double *, const double *, const double *, const double *, const double *, double *);
typedef void (*hoist_fn)(const double *, double *);
typedef int (*casadi_fn)(const double **, double **, long long *, double *, int);
typedef void (*heyoka_fn)(double *, const double *, const double *, const double *);

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#define LOOP(CALL)                              \
    const double x0 = x[0], start = seconds();  \
    volatile double sink;                       \
    for (long i = 0; i < n; i++) {              \
        x[0] = x0 + (double)(i & 1) * 1e-10;    \
        CALL;                                   \
        sink = out[0];                          \
    }                                           \
    (void)sink;                                 \
    x[0] = x0;                                  \
    return seconds() - start;

double loop_program(long n, program_fn f, double t, double *x, const double *p, const double *r, const double *h,
                    double *out)
{
    LOOP(f(t, x, p, r, h, out))
}

double loop_lanes(long n, lanes_fn f, const double *t, double *x, const double *p, const double *r, const double *h,
                  double *out)
{
    LOOP(f(t, x, p, r, h, out))
}

double loop_program_hoisting(long n, program_fn f, hoist_fn hoist, double t, double *x, const double *p,
                             const double *r, double *h, double *out)
{
    LOOP(hoist(p, h); f(t, x, p, r, h, out))
}

double loop_casadi(long n, casadi_fn f, double *x, const double *p, double *out, long long *iw, double *w)
{
    const double *arg[16] = {x, p};
    double *res[16] = {out};
    LOOP(f(arg, res, iw, w, 0))
}

double loop_heyoka(long n, heyoka_fn f, double t, double *x, const double *p, double *out)
{
    LOOP(f(out, x, p, &t))
}
