static void indicate(unit *i, double *out);
static void tell_event(const unit *i, int64_t event, double t);

/* The values that events set, all from the state before; how their quantities leave zero then. */
static status act_on(unit *i, const bool *there, const double *before, bool *changed, bool *ends)
{
    @NAME@_motion *m = &i->now.m;
    double values[ACTIONS];
    bool set[STATES];
    double old[INDICATORS];
    double now[INDICATORS];
    double slope[INDICATORS];
    for (int64_t k = 0; k < STATES; k++) {
        set[k] = false;
    }
    @NAME@_tendency(beside(i), m->y, m->p, m->r, m->h, old);
    @NAME@_act(beside(i), m->y, m->p, m->r, m->h, values);
    for (int64_t k = 0; k < ACTIONS; k++) {
        const int64_t place = (int64_t)at_actions[(2 * k) + 1];
        if (there[(int64_t)at_actions[2 * k]]) {
            if (!isfinite(values[k]) || (set[place] && (m->y[place] != values[k]))) {
                return failed(i, "Expected one finite value of a state at an event, got none, or two that differ.");
            }
            m->y[place] = values[k];
            set[place] = true;
            *changed = true;
        }
    }
    indicate(i, now);
    @NAME@_tendency(beside(i), m->y, m->p, m->r, m->h, slope);
    for (int64_t k = 0; k < INDICATORS; k++) {
        const double way = at_kinds[(k * KINDS) + 1];
        const bool leapt = !there[k] && ((before[k] * now[k]) < 0.0) && ((way == 0.0) || ((way * now[k]) > 0.0));
        if (leapt && (at_kinds[k * KINDS] >= @ACTS@.0)) {
            return failed(i, "An action leads beyond the threshold of another event. Simulate it with kane.");
        }
        if (leapt && (at_kinds[(k * KINDS) + 2] > 0.0)) {
            tell_event(i, k, i->now.time);
            *ends = *ends || (at_kinds[(k * KINDS) + 3] > 0.0);
        }
        i->now.shift[k] = 0.0;
        /* what turned back leaves zero to where it came from, whatever sign rounding gives it */
        if (there[k] && ((slope[k] * now[k]) < 0.0) && ((slope[k] * old[k]) < 0.0)) {
            i->now.shift[k] = -2.0 * now[k];
        }
    }
    return DONE;
}
