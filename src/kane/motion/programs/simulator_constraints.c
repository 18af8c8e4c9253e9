/*
 * Whether the kernel is to go on where it has asked: a step is taken at whose end dependent speeds hardly follow; one that may have led
 * where they do not follow is taken again, half as long.
 */
static bool goes_on(@NAME@_motion *m)
{
    const double shortest = m->s[AT_SHORTEST] + (@TEN_ROUNDINGS@ * fabs(m->s[AT_TIME]));
    const double left = (m->s[AT_END] - m->s[AT_TIME]) - m->s[AT_TIME_LAG];
    const double half = 0.5 * fmin(fmin(fmax(m->s[AT_STEP], shortest), m->s[AT_LONGEST]), left);
    const bool asked = (m->s[AT_HELD] > 0.0) && !(m->s[AT_LOOKED] > 0.0);
    const bool poorer = asked && (m->s[AT_HELD] == @POORER@) && (m->s[AT_SHARE] <= @UNUSABLE@);
    const bool shorter = asked && !poorer && (half > (@SAME_TIME@ * m->end));
    if (poorer) {
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
    @NAME@_holding(m->start, m->y, m->p, m->r, at_held_h, at_held_room);
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
            if ((int64_t)at_held_entry_at[(3 * e) + 1] == i) {
                const int64_t at = COORDINATES + (int64_t)at_held_entry_at[(3 * e) + 2];
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
        at_held_reach[e] = 0.0;
    }
    m->p[@CAPS@_PARAMETERS] = 0.0;
    at_held_log[0] = 0.0;
    return @CAPS@_BEGUN;
}

