static double at_none[@ARGUMENTS@][1];

/* The share of the dependent speeds' block of the constraints in them at the state at hand, by a choice of these speeds: the larger, the worse. */
static double share_of(int choice, double *s, double *y, double *p, double *r, double *h)
{
    double there[@SIZE@];
    memcpy(there, s, sizeof there);
    at_choice = choice;
    (void)@REGULARITY@;
    return there[AT_SHARE];
}

/* Whether the kernel is to go on where it has asked: with other dependent speeds, which follow better, or with these, which follow well. */
static int goes_on(double *s, double *y, double *p, double *r, double *h)
{
    const int own = at_choice;
    const double reached = s[AT_SHARE];
    int best = own;
    if (s[AT_HELD] != @POORER@) return 0;
    double least = share_of(own, s, y, p, r, h) / @BETTER@;
    for (int k = 0; k < CHOICES; k++) {
        const double share = k == own ? HUGE_VAL : share_of(k, s, y, p, r, h);
        if (share < least) best = k, least = share;
    }
    at_choice = best;
    if (best != own) {
        s[AT_FRESH] = 1;
        s[AT_QUIET] = @QUIET@;
        if (!@FIXED@) s[AT_STEP] = 0;
        fprintf(stderr, "other dependent speeds at t = %.17g\n", s[AT_TIME]);
        return 1;
    }
    s[AT_LOOKED] = 1;
    s[AT_QUIET] = 1.25 * reached;
    return reached <= @UNUSABLE@;
}

/* Whether the start satisfies the constraints. */
static int begin_constraints(double *y, double *p, double *r, double *h)
{
    double *out = at_held_room;
    memcpy(at_held_h, h, sizeof at_held_h);
    run_constraints(0, y, p, r, h, out);
    const double *f = out, *terms = f + CLOSURES, *b = terms + CLOSURES, *a = b + ROWS + BRANCHES;
    for (int i = 0; i < ROWS; i++) {
        double left = i < CLOSURES ? f[i] : 0, size = i < CLOSURES ? terms[i] : 0, rate = b[i], speeds = fabs(b[i]);
        for (int e = 0; e < ENTRIES; e++)
            if ((int)at_held_entry_at[0][3 * e + 1] == i) {
                const double part = a[e] * y[COORDINATES + (int)at_held_entry_at[0][3 * e + 2]];
                rate += part;
                speeds += fabs(part);
            }
        if (!(fabs(left) <= 1e-6 * size) || !(fabs(rate) <= 1e-6 * speeds)) {
            fprintf(stderr, "Expected a start on the constraints, got %.3g left of %s and %.3g of its rate. Assemble the state.\n", left, at_constraints[i], rate);
            return 0;
        }
    }
    return 1;
}
