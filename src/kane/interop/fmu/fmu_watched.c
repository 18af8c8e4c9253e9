@EVENT_NAMES@
/* The quantities of the events over their thresholds. */
static void indicate(unit *i, double *out)
{
    const @NAME@_motion *m = &i->now.m;
    @NAME@_events(beside(i), m->y, m->p, m->r, m->h, out);
    for (int64_t k = 0; k < INDICATORS; k++) {
        out[k] -= at_least[k];
    }
}

/* On which sides the indicators are. */
static void note_sides(unit *i)
{
    double now[INDICATORS];
    indicate(i, now);
    for (int64_t k = 0; k < INDICATORS; k++) {
        i->now.was[k] = ((now[k] + i->now.shift[k]) > 0.0) ? 1.0 : -1.0;
    }
}

/* Indicators that left zero count as they are. */
static void unshift(unit *i)
{
    double now[INDICATORS];
    indicate(i, now);
    for (int64_t k = 0; k < INDICATORS; k++) {
        const bool left = (now[k] * i->now.was[k]) > 0.0;
        i->now.shift[k] = left ? 0.0 : i->now.shift[k];
    }
}

/* Quantities of events after inputs or parameters were changed between steps; those that are leaving thresholds stay there. */
static void seen_anew(unit *i)
{
    @NAME@_motion *m = &i->now.m;
    double now[INDICATORS];
    @NAME@_events(beside(i), m->y, m->p, m->r, m->h, now);
    for (int64_t k = 0; k < INDICATORS; k++) {
        if (!(at_leaves[k * @LEAVES@] > 0.0)) {
            at_seen[k] = now[k];
        }
    }
}

/* Says which event there was. */
static void tell_event(const unit *i, int64_t event, double t)
{
    char text[512];
    (void)snprintf(text, sizeof text, "%s at t = %.17g", at_names[event], t);
    (void)told(i, DONE, "logEvents", text);
}

/* Events of the last step are logged; whether the importer is to be asked at one, which then finds the state before it. */
static bool noted(unit *i, int said)
{
    @NAME@_motion *m = &i->now.m;
    bool acts = false;
    for (int64_t k = 0; k < (int64_t)m->s[AT_LOGGED]; k++) {
        const int64_t event = (int64_t)at_log[(2 * k) + 1];
        tell_event(i, event, at_log[2 * k]);
        acts = acts || (at_kinds[event * KINDS] >= @ACTS@.0);
    }
    m->s[AT_LOGGED] = 0.0;
    m->s[AT_JUMPS] = 0.0;
    const bool asks = acts && i->event_mode && i->early && (said < @CAPS@_UNDECIDED);
    if (asks) {
        for (int64_t k = 0; k < N; k++) {
            i->now.next[k] = m->y[k];
            m->y[k] = at_jumps[2 + k];
        }
        i->now.pending = true;
    }
    return asks;
}

/* How the quantities that are at their thresholds at the start leave them; whether their rates tell. */
static bool leaves_threshold(unit *i)
{
    @NAME@_motion *m = &i->now.m;
    double slope[INDICATORS];
    double beside_them[2 * INDICATORS];
    @NAME@_tendency(m->start, m->y, m->p, m->r, m->h, slope);
    @NAME@_glance(m->start, m->y, m->p, m->r, m->h, beside_them);
    for (int64_t k = 0; k < INDICATORS; k++) {
        const bool own = at_kinds[(k * KINDS) + 2] > 0.0;
        double *row = &at_leaves[k * @LEAVES@];
        if (own && !(fabs(at_seen[k] - at_least[k]) > (@ROUNDED_TERMS@ * beside_them[INDICATORS + k]))) {
            const double side = (slope[k] > 0.0) ? 1.0 : -1.0;
            const bool there = (at_kinds[(k * KINDS) + 1] * side) >= 0.0;
            if (!(fabs(slope[k]) > 0.0) || (there && (at_kinds[k * KINDS] > 0.0))) {
                return false;
            }
            row[0] = 1.0;
            row[1] = side;
            row[2] = 1.0;
            row[3] = 0.0;
            row[4] = @LATER@;
            at_seen[k] = at_least[k];
            i->now.was[k] = side;
            if (there) {
                tell_event(i, k, m->start);
            }
        }
    }
    return true;
}

/* Whether the passage of an event at these values is one, by its direction. */
static bool passed(const unit *i, int64_t event, double now)
{
    const double way = at_kinds[(event * KINDS) + 1];
    const double side = ((now + i->now.shift[event]) > 0.0) ? 1.0 : -1.0;
    return (side != i->now.was[event]) && ((way == 0.0) || (way == side));
}

/* Which events there are at an event of continuous time, and what they do. */
static status acted(unit *i, bool *changed, bool *ends)
{
    const @NAME@_motion *m = &i->now.m;
    double now[INDICATORS];
    bool there[INDICATORS];
    bool any = false;
    indicate(i, now);
    for (int64_t k = 0; k < INDICATORS; k++) {
        there[k] = passed(i, k, now[k]);
        if (there[k] && (at_kinds[k * KINDS] >= @ASKED@.0)) {
            return failed(i, "Numbers alone do not tell how the motion goes on at an event. Simulate it with kane.");
        }
        if (there[k]) {
            any = true;
            tell_event(i, k, i->now.time);
            *ends = *ends || (at_kinds[(k * KINDS) + 3] > 0.0);
        }
    }
    if (!any) {
        note_sides(i);
        return DONE;
    }
    (void)m;
    const status said = act_on(i, there, now, changed, ends);
    note_sides(i);
    return said;
}
