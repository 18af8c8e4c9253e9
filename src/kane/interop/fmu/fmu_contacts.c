@EVENT_NAMES@
/* Says what contacts do from a time on. */
static void tell_mode(const unit *i, double t, int64_t which)
{
    char text[512];
    size_t at = (size_t)snprintf(text, sizeof text, "at t = %.17g", t);
    for (int64_t k = 0; (k < CONTACTS) && (at < sizeof text); k++) {
        const char *const word = at_words[k][at_digits[which][k]];
        at += (size_t)snprintf(&text[at], sizeof text - at, "%s %s: %s", (k > 0) ? "," : ":", at_contacts[k], word);
    }
    (void)told(i, DONE, "logEvents", text);
}

/* Events and modes of the last call are logged; whether the importer is to be asked where one ended, and then finds the state before. */
static bool noted(unit *i, int said)
{
    @NAME@_motion *m = &i->now.m;
    const int64_t rows = (int64_t)at_records[0];
    int64_t done = 0;
    char text[512];
    for (int64_t k = 0; k < rows; k++) {
        const double *row = &at_records[2 + (k * WIDTH)];
        const int64_t which = (int64_t)row[ROW_MODE];
        if ((k > 0) || !m->goes_on) {
            tell_mode(i, row[ROW_BEGIN], which);
        }
        for (; done < (int64_t)row[ROW_NOTED]; done++) {
            (void)snprintf(text, sizeof text, "%s at t = %.17g", at_names[which][(int64_t)at_noted[(2 * done) + 1]], at_noted[2 * done]);
            (void)told(i, DONE, "logEvents", text);
        }
    }
    const bool asks = i->event_mode && i->early && (said == @CAPS@_NOTED) && (m->enter == 1);
    for (int64_t k = 0; (k < N) && asks; k++) {
        i->now.next[k] = m->y[k];
        m->y[k] = at_records[2 + ((rows - 1) * WIDTH) + LAST_STATE + k];
    }
    i->now.pending = asks;
    return asks;
}

/* The mode at hand begins, without a step: whether it does. */
static bool begins(unit *i)
{
    @NAME@_motion *m = &i->now.m;
    const double end = m->end;
    m->s[AT_END] = m->s[AT_TIME];
    m->end = (double)INFINITY;
    m->fresh = false;
    m->at_once = AT_ONCE;
    const int said = @NAME@_go_on(m);
    m->end = end;
    m->at_once = (i->event_mode && i->early) ? 1 : AT_ONCE;
    return said < @CAPS@_END;
}

/* What contacts do at the start, impacts among it. */
static bool settled(unit *i)
{
    return begins(i) || (failed(i, "Numbers alone do not tell what contacts do here, or a mode begins that the unit does not have.") == DONE);
}
