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

/* Which quantities are at their thresholds at the start, and whether their rates tell to which side they leave. */
static bool at_thresholds(const unit *i, const double *slope, bool *at, bool *there)
{
    const @NAME@_motion *m = &i->now.m;
    double values[2 * INDICATORS];
    bool told_by_rates = true;
    @NAME@_glance(m->start, m->y, m->p, m->r, m->h, values);
    for (int64_t k = 0; k < INDICATORS; k++) {
        const bool own = at_kinds[(k * KINDS) + 2] > 0.0;
        const double way = at_kinds[(k * KINDS) + 1];
        at[k] = own && !(fabs(values[k] - at_least[k]) > (@ROUNDED_TERMS@ * values[INDICATORS + k]));
        there[k] = at[k] && ((way == 0.0) || ((way * slope[k]) > 0.0));
        told_by_rates = told_by_rates && (!at[k] || (fabs(slope[k]) > 0.0));
    }
    return told_by_rates;
}

/*
 * A start on thresholds, where rates tell how quantities leave them: an event at which the motion passes its threshold is of that instant,
 * as in kane, and acts. In model exchange the importer finds those that act.
 */
static bool leaves_threshold(unit *i)
{
    @NAME@_motion *m = &i->now.m;
    double slope[INDICATORS];
    double now[INDICATORS];
    bool at[INDICATORS];
    bool there[INDICATORS];
    bool changed = false;
    @NAME@_tendency(m->start, m->y, m->p, m->r, m->h, slope);
    if (!at_thresholds(i, slope, at, there)) {
        return false;
    }
    for (int64_t k = 0; k < INDICATORS; k++) {
        const bool acts = at_kinds[k * KINDS] >= @ACTS@.0;
        if (there[k] && acts && (i->what == EXCHANGE)) {
            at[k] = false;
        } else if (there[k]) {
            tell_event(i, k, m->start);
            i->now.ended = i->now.ended || (at_kinds[(k * KINDS) + 3] > 0.0);
        } else {
            /* it leaves without passing */
        }
        there[k] = there[k] && acts && (i->what == STEPPED);
    }
    indicate(i, now);
    if (act_on(i, there, now, &changed, &i->now.ended) != DONE) {
        return false;
    }
    @NAME@_tendency(m->start, m->y, m->p, m->r, m->h, slope);
    @NAME@_events(m->start, m->y, m->p, m->r, m->h, at_seen);
    for (int64_t k = 0; k < INDICATORS; k++) {
        const double row[@LEAVES@] = {1.0, (slope[k] > 0.0) ? 1.0 : -1.0, 1.0, 0.0, @LATER@};
        for (int64_t j = 0; (j < @LEAVES@) && at[k]; j++) {
            at_leaves[(k * @LEAVES@) + j] = row[j];
        }
        if (at[k]) {
            at_seen[k] = there[k] ? at_seen[k] : at_least[k];
            i->now.was[k] = row[1];
        }
        at_largest[k] = fabs(at_seen[k]);
    }
    return true;
}

