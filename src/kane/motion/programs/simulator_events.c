/* The quantities of the events at the start; whether none stands at its threshold, where none is known to have passed it. */
static int begin_events(@NAME@_motion *m)
{
    double beside[2 * SEEN];
    @NAME@_events(m->start, m->y, m->p, m->r, m->h, at_seen);
    @NAME@_glance(m->start, m->y, m->p, m->r, m->h, beside);
    for (int64_t k = 0; k < SEEN; k++) {
        at_largest[k] = fabs(at_seen[k]);
    }
    for (int64_t k = 0; k < EVENTS; k++) {
        const bool own = at_kinds[(k * KINDS) + 2] > 0.0;
        if (own && !(fabs(at_seen[k] - at_least[k]) > (@ROUNDED_TERMS@ * beside[SEEN + k]))) {
            m->which = k;
            return @CAPS@_ON_THRESHOLD;
        }
    }
    for (int64_t k = 0; k < LEAVING; k++) {
        at_leaves[k] = 0.0;
    }
    return @CAPS@_BEGUN;
}

