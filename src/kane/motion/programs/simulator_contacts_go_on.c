/*
 * What events watch of the mode at hand after a pause, where inputs or parameters may have changed: one whose contact would open or slip
 * ends the mode now.
 */
static void look_again(@NAME@_motion *m)
{
    const int64_t mode = (int64_t)at_calls[0];
    look_mode(m, m->s[AT_TIME], m->y, m->r, at_calls, at_glanced);
    for (int64_t k = 0; k < (int64_t)at_own_events[mode]; k++) {
        const int64_t at = (mode * EVENTS_OF) + k;
        const double kind = at_meaning[(2 * at) + 1];
        const bool strains = (at_meaning[2 * at] >= 0.0) && (kind >= @OPENS@.0) && (kind <= @SLIPS@.0);
        if (!(at_leaves[at * LEAVING] > 0.0)) {
            at_seen[at] = at_glanced[k];
        }
        if (strains && (at_glanced[k] < 0.0) && (m->enter == 0)) {
            m->enter = AGAIN + k;
            m->kept = -1;
        }
    }
}

/* What a call has come to, by why the kernel came back; a mode that goes on has its row of `records` in the next call too. */
static int came_to(@NAME@_motion *m, int64_t back)
{
    const bool ends = !(m->s[AT_END] < m->end);
    const int64_t rows = (int64_t)at_records[0];
    int said = (rows > 0) ? @CAPS@_NOTED : @CAPS@_LIMIT;
    bool again = false; /* whether a step is taken again, or gone on from */
    m->kept = -1;
    m->enter = 1;
    @LOOKS@
    if (back == @BACK_END@) { /* the mode goes on after a pause */
        m->enter = 0;
        m->kept = rows - 1;
        m->s[AT_LOGGED] = 0.0;
        m->s[AT_JUMPS] = 0.0;
    }
    if ((back == @BACK_END@) && !ends) {
        m->s[AT_TIME] = m->s[AT_END] + ((4.0 * @ULPS@.0) * spacing(m->s[AT_END]));
        m->s[AT_TIME_LAG] = 0.0;
        m->fresh = true;
    } else if ((back == @BACK_LIMIT@) || again) {
        m->enter = 0;
        m->kept = rows;
    } else if ((back == @BACK_END@) || ((back == @BACK_LATE@) && ends)) {
        said = @CAPS@_END;
        if (back == @BACK_LATE@) {
            close_row(m, m->s[AT_END]);
        }
    } else if (back == @BACK_LATE@) {
        m->fresh = true;
    } else if (back == @BACK_EVENT@) {
        said = @CAPS@_EVENT;
    } else if (back == @BACK_UNKNOWN@) {
        said = @CAPS@_UNKNOWN;
    } else if (back == @BACK_FULL@) {
        said = @CAPS@_NOTED;
    } else {
        const bool stuck = (back == @BACK_TAKE@) && ((at_calls[1] == @UNDERFLOW@.0) || (at_calls[1] == @NOT_FINITE@.0));
        said = stuck ? @CAPS@_STUCK : @CAPS@_UNDECIDED;
        if (back == @BACK_TAKE@) { /* within a mode */
            close_row(m, m->s[AT_TIME]);
        }
    }
    return said;
}

/* Steps, up to `limit` of a mode; modes that are over stand in `at_records`. */
int @NAME@_go_on(@NAME@_motion *m)
{
    const bool pause = m->fresh;
    if (pause) {
        @ASK_AGAIN@
        aim(m);
    }
    if (pause && (m->enter == 0)) {
        look_again(m);
    }
    @FORGET@
    m->goes_on = (m->kept >= 0) && (pause || (m->goes_on && (m->kept == 0)));
    for (int64_t k = 0; (k < WIDTH) && (m->kept > 0); k++) {
        at_records[2 + k] = at_records[2 + (m->kept * WIDTH) + k];
    }
    if (m->goes_on && pause) {
        at_records[2 + ROW_FIRST_SAMPLE] = m->s[AT_SAMPLE];
    }
    return came_to(m, @CALL@);
}
