/* The sizes of rows and columns of A are those that its entries have had by now. */
static void measure(void)
{
    double most = 0.0;
    double rows[ROWS + 1];
    double columns[SPEEDS + 1];
    for (int64_t i = 0; i < (ROWS + 1); i++) {
        rows[i] = 0.0;
    }
    for (int64_t j = 0; j < (SPEEDS + 1); j++) {
        columns[j] = 0.0;
    }
    for (int64_t e = 0; e < ENTRIES; e++) {
        at_known[e] = fmax(at_known[e], at_held_reach[e]);
        most = fmax(most, at_known[e]);
    }
    for (int64_t e = 0; e < ENTRIES; e++) {
        const int64_t i = (int64_t)at_held_entry_at[0][(3 * e) + 1];
        if (at_known[e] > (@ROUNDED@ * most)) {
            rows[i] = fmax(rows[i], at_known[e]);
        }
    }
    for (int64_t i = 0; i < ROWS; i++) {
        rows[i] = (rows[i] > 0.0) ? rows[i] : 1.0;
        at_held_row_sizes[i] = 1.0 / rows[i];
    }
    for (int64_t e = 0; e < ENTRIES; e++) {
        const int64_t i = (int64_t)at_held_entry_at[0][(3 * e) + 1];
        const int64_t j = (int64_t)at_held_entry_at[0][(3 * e) + 2];
        if (at_known[e] > (@ROUNDED@ * most)) {
            columns[j] = fmax(columns[j], at_known[e] / rows[i]);
        }
    }
    for (int64_t j = 0; j < SPEEDS; j++) {
        at_held_column_sizes[j] = 1.0 / ((columns[j] > 0.0) ? columns[j] : 1.0);
    }
    for (int64_t e = 0; e < ENTRIES; e++) {
        const int64_t i = (int64_t)at_held_entry_at[0][(3 * e) + 1];
        const int64_t j = (int64_t)at_held_entry_at[0][(3 * e) + 2];
        at_held_weights[e] = at_held_row_sizes[i] * at_held_column_sizes[j];
    }
}

/* The share of the dependent speeds' block of the constraints in them at the state at hand, by a choice of these speeds: the larger, the worse. */
static double share_of(@NAME@_motion *m, int choice)
{
    double there[@SIZE@];
    const int own = at_choice;
    for (int64_t k = 0; k < @SIZE@; k++) {
        there[k] = m->s[k];
    }
    at_choice = choice;
    (void)@REGULARITY@;
    at_choice = own;
    return there[AT_SHARE];
}

/* After a step at whose end the dependent speeds follow worse: whether others, which follow much better, lead on. */
static bool settled(@NAME@_motion *m)
{
    const int own = at_choice;
    const double reached = m->s[AT_SHARE];
    int best = own;
    m->looked = false;
    m->s[AT_LOOKED] = 0.0;
    const double now = share_of(m, own);
    double least = now / @BETTER@;
    for (int k = 0; k < CHOICES; k++) {
        if (k != own) {
            const double share = share_of(m, k);
            if (share < least) {
                best = k;
                least = share;
            }
        }
    }
    measure();
    if ((best == own) || (now <= @QUIET@)) {
        m->s[AT_QUIET] = fmax(m->s[AT_QUIET], 1.25 * reached);
        return false;
    }
    at_choice = best;
    for (int64_t e = 0; e < ENTRIES; e++) {
        at_held_reach[e] = 0.0;
    }
    for (int64_t k = 0; k < N; k++) {
        m->lag[k] = 0.0;
    }
    m->s[AT_TIME_LAG] = 0.0;
    m->s[AT_QUIET] = @QUIET@;
    m->fresh = true;
    return true;
}

/*
 * Whether the kernel is to go on where it has asked: dependent speeds that hardly follow are looked at after the step; a step that may
 * have led where they do not follow is taken again, half as long.
 */
static bool goes_on(@NAME@_motion *m)
{
    const double shortest = m->s[AT_SHORTEST] + (@TEN_ROUNDINGS@ * fabs(m->s[AT_TIME]));
    const double left = (m->s[AT_END] - m->s[AT_TIME]) - m->s[AT_TIME_LAG];
    const double half = 0.5 * fmin(fmin(fmax(m->s[AT_STEP], shortest), m->s[AT_LONGEST]), left);
    const bool asked = (m->s[AT_HELD] > 0.0) && !m->looked;
    const bool poorer = asked && (m->s[AT_HELD] == @POORER@) && (m->s[AT_SHARE] <= @UNUSABLE@);
    const bool shorter = asked && !poorer && (half > (@SAME_TIME@ * m->end));
    if (poorer) {
        measure();
        m->looked = true;
        m->s[AT_LOOKED] = 1.0;
    }
    if (shorter) {
        m->s[AT_STEP] = half;
    }
    return poorer || shorter;
}

/* Whether the start satisfies the constraints. */
static int begin_constraints(@NAME@_motion *m)
{
    for (int64_t k = 0; k < (@CAPS@_HOISTED + 1); k++) {
        at_held_h[k] = m->h[k];
    }
    at_choice = 0;
    @NAME@_holding(0.0, m->y, m->p, m->r, at_held_h, at_held_room);
    double fastest = 0.0; /* a row of which all speeds are rounding is judged beside the others */
    for (int64_t j = 0; j < SPEEDS; j++) {
        fastest = fmax(fastest, fabs(m->y[COORDINATES + j]));
    }
    for (int64_t i = 0; i < ROWS; i++) {
        const double b = at_held_room[(2 * CLOSURES) + i];
        const double left = (i < CLOSURES) ? at_held_room[i] : 0.0;
        const double size = (i < CLOSURES) ? at_held_room[CLOSURES + i] : 0.0;
        double rate = b;
        double speeds = fabs(b);
        for (int64_t e = 0; e < ENTRIES; e++) {
            if ((int64_t)at_held_entry_at[0][(3 * e) + 1] == i) {
                const int64_t at = COORDINATES + (int64_t)at_held_entry_at[0][(3 * e) + 2];
                const double entry = at_held_room[(2 * CLOSURES) + ROWS + BRANCHES + e];
                rate += entry * m->y[at];
                speeds += fabs(entry) * fastest;
            }
        }
        if (!(fabs(left) <= (1e-6 * size)) || !(fabs(rate) <= (1e-6 * speeds))) {
            m->which = i;
            m->left = left;
            m->rate = rate;
            return @CAPS@_OPEN;
        }
    }
    for (int64_t e = 0; e < ENTRIES; e++) {
        at_known[e] = fabs(at_held_room[(2 * CLOSURES) + ROWS + BRANCHES + e]);
        at_held_reach[e] = 0.0;
    }
    measure();
    m->s[AT_QUIET] = @QUIET@;
    return @CAPS@_BEGUN;
}

