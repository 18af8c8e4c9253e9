/* SPDX-License-Identifier: BSD-3-Clause
 *
 * Seconds of processor time of n calls of mj_forward; the last coordinate moves by 1e-10 between calls.
 */
#include <mujoco/mujoco.h>
#include <time.h>

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double tree_forward(long n, const mjModel *m, mjData *d)
{
    const double last = d->qpos[m->nq - 1], start = seconds();
    for (long i = 0; i < n; i++) {
        d->qpos[m->nq - 1] = last + (double)(i & 1) * 1e-10;
        mj_forward(m, d);
    }
    const double taken = seconds() - start;
    d->qpos[m->nq - 1] = last;
    mj_forward(m, d);
    return taken;
}
