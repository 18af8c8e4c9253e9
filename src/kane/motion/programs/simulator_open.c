/* Whether the start satisfies the constraints. */
static int begin_on_constraints(@NAME@_motion *m)
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
    return @CAPS@_BEGUN;
}
