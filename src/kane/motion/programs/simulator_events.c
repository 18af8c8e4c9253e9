/* The quantities of the events at the start; whether none stands at its threshold, where none is known to have passed it. */
static int begin_events(@NAME@_motion *m)
{
    double beside[2 * EVENTS];
    for (int64_t k = 0; k < (@CAPS@_HOISTED + 1); k++) {
        at_hw[k] = m->h[k];
        at_hg[k] = m->h[k];
        at_ht[k] = m->h[k];
        at_ha[k] = m->h[k];
    }
    @NAME@_events(0.0, m->y, m->p, m->r, m->h, at_seen);
    @NAME@_glance(0.0, m->y, m->p, m->r, m->h, beside);
    for (int64_t k = 0; k < EVENTS; k++) {
        const bool own = at_kinds[(k * KINDS) + 2] > 0.0;
        at_largest[k] = fabs(at_seen[k]);
        if (own && !(fabs(at_seen[k] - at_least[k]) > (@ROUNDED_TERMS@ * beside[EVENTS + k]))) {
            m->which = k;
            return @CAPS@_ON_THRESHOLD;
        }
    }
    for (int64_t k = 0; k < LEAVING; k++) {
        at_leaves[k] = 0.0;
    }
    return @CAPS@_BEGUN;
}

