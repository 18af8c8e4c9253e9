
/*
 * The motion: @METHOD@ from time `start` on, in steps that end where rates jump or bend at times that parameters set, and where pulses of
 * time begin, have their top, and end. Nothing is allocated, no function calls itself, and no loop is without a bound. Fill y, p, r,
 * rtol, atol, max_step and limit of a @NAME@_motion, which @NAME@_defaults does but for what has no default; @NAME@_begin takes the time
 * of the end and how many samples there are; then call @NAME@_go_on until it gives no code below @CAPS@_END: a call is `limit` steps at most.
 * A motion holds all that changes, and no pointers: a copy of it goes on as it does. With @CAPS@_NO_MAIN defined there is no main, and
 * nothing is printed.
 */
enum {
@PLACES@
    N = @CAPS@_STATES + 1, /* the state, and the work of the loads since the beginning */
    TURNING = @TURNING@, /* so many quantities turn something where they come to a level; then come their slopes, then pulses */
    PULSES = @PULSES@,
    PLACES = @LOOKED_AT@, /* at so many times pulses are looked for */
    MOST_PULSES = @MOST_PULSES@,
    STOPS = @STOPS@ /* at most so many times at which steps end, besides those of a controller */
};

#ifndef @CAPS@_SAMPLES
#define @CAPS@_SAMPLES 10000
#endif

/* What @NAME@_go_on gives: it is to be called again, where events are to be read before; the end; why there is no end. */
enum {
    @CAPS@_LIMIT = 0,
    @CAPS@_NOTED = 1,
    @CAPS@_END = 2,
    @CAPS@_EVENT = 3, /* an event that ends the motion */
    @CAPS@_UNDECIDED = 4, /* numbers alone do not tell how the motion goes on */
    @CAPS@_STUCK = 5@CODES@
};

/* What @NAME@_begin gives. */
enum {
    @CAPS@_BEGUN = 0,
    @CAPS@_WRONG = 1, /* the end, tolerances or the longest step are not above zero, or there are too few or too many samples */
    @CAPS@_OPEN = 2, /* the start is off the constraint `which`, by `left`, or its rate by `rate` */
    @CAPS@_ON_THRESHOLD = 3 /* the event `which` is at its threshold at the start */
};

typedef struct {
    double s[@SIZE@];
    double y[N];
    double lag[N];
    double work[@WORK@];
    double p[@CAPS@_PARAMETERS + 1];
    double r[@CAPS@_INPUTS + 1];
    double h[@CAPS@_HOISTED + 1];
    double times[@CAPS@_SAMPLES + 1];
    double rows[@CAPS@_SAMPLES * N];
    double marks[@CAPS@_SAMPLES];
    double stops[STOPS + 1];
    int64_t stop_count;
    int64_t stop;
    int64_t asked;
    int64_t samples;
    int64_t limit;
    double start;
    double end;
    double rtol;
    double atol;
    double max_step;
    int64_t which;
    double left;
    double rate;
    bool fresh;
@OWN_FIELDS@@FIELDS@} @NAME@_motion;

void @NAME@_defaults(@NAME@_motion *m);
int @NAME@_begin(@NAME@_motion *m, double end, int64_t samples);
int @NAME@_go_on(@NAME@_motion *m);
@CONTROL@
@LEVELS@

@TABLES@
@KERNEL@
@FILL_TABLES@
/* The distance to the next number away from zero. */
static double spacing(double t)
{
    return nextafter(fabs(t), (double)INFINITY) - fabs(t);
}

@FIND_STOPS@/* Whether the next stop is behind t, or leaves no room for a step before it: then t is moved beyond it. */
static bool is_behind(const @NAME@_motion *m, double *t)
{
    bool behind = false;
    if ((m->stop < m->stop_count) && (m->stops[m->stop] < m->end)) {
        const double stop = m->stops[m->stop];
        const double before = stop - (@ULPS@.0 * spacing(stop));
        const double beyond = before + ((4.0 * @ULPS@.0) * spacing(before));
        const double room = *t + ((4.0 * @ULPS@.0) * spacing(*t));
        behind = (stop <= *t);
        if (!behind && (before <= room) && (beyond < m->end)) {
            *t = beyond;
            behind = true;
        }
    }
    return behind;
}

/* Where the step from the time at hand on begins and ends: just before the next stop. */
static void aim(@NAME@_motion *m)
{
    double t = m->s[AT_TIME];
    double stop = m->end;
    for (int64_t turn = 0; turn <= STOPS; turn++) {
        if (!is_behind(m, &t)) {
            break;
        }
        m->stop++;
    }
    m->s[AT_TIME] = t;
    if (m->stop < m->stop_count) {
        stop = m->stops[m->stop];
    }
    @AIM_AT_CONTROL@
    m->s[AT_END] = (stop < m->end) ? fmax(t, stop - (@ULPS@.0 * spacing(stop))) : m->end;
    m->s[AT_STEP] = @FIXED@ ? m->max_step : 0.0;
    m->s[AT_FRESH] = 1.0;
    m->s[AT_SIDED] = 0.0;
    m->s[AT_TURNING] = 0.0;
    m->fresh = false;
}

@CONSTRAINTS@
@EVENTS@
/* The state at the start, parameters and settings by default; NAN where there is none. */
void @NAME@_defaults(@NAME@_motion *m)
{
    for (int64_t k = 0; k < @CAPS@_STATES; k++) {
        m->y[k] = @NAME@_state[k].value;
    }
    for (int64_t k = 0; k < @CAPS@_PARAMETERS; k++) {
        m->p[k] = @NAME@_parameters[k].value;
    }
    for (int64_t k = 0; k < (@CAPS@_INPUTS + 1); k++) {
        m->r[k] = (double)NAN;
    }
    m->p[@CAPS@_PARAMETERS] = 0.0;
    m->start = 0.0;
    m->rtol = 1e-9;
    m->atol = 1e-9;
    m->max_step = @FIXED@ ? (double)NAN : (double)INFINITY;
    m->limit = 1000;
}

/* From the state y of m at time `start` on. */
int @NAME@_begin(@NAME@_motion *m, double end, int64_t samples)
{
    const bool above = (m->rtol > 0.0) && (m->atol > 0.0) && (m->max_step > 0.0) && (end > m->start) && isfinite(end - m->start);
    if (!above || (samples < 2) || (samples > @CAPS@_SAMPLES) || (m->limit < 1)) {
        return @CAPS@_WRONG;
    }
    m->end = end;
    m->samples = samples;
    m->y[N - 1] = 0.0;
    for (int64_t k = 0; k < @SIZE@; k++) {
        m->s[k] = 0.0;
    }
    for (int64_t k = 0; k < N; k++) {
        m->lag[k] = 0.0;
    }
    for (int64_t k = 0; k < @WORK@; k++) {
        m->work[k] = 0.0;
    }
    m->h[@CAPS@_HOISTED] = 0.0;
    fill_tables(m);
    @ASK@
    hoist(m);
    const int64_t parts = samples - 1;
    const double step = (end - m->start) / (double)parts;
    for (int64_t k = 0; k < samples; k++) {
        m->times[k] = (k == parts) ? end : (m->start + ((double)k * step));
        m->marks[k] = 0.0;
    }
    m->times[samples] = (double)INFINITY; /* one more, after the end */
    for (int64_t k = 0; k < N; k++) {
        m->rows[k] = m->y[k];
    }
    m->stop_count = 0;
    @STOPS_FOUND@
    m->stop = 0;
    m->asked = 1;
    m->which = 0;
    m->left = 0.0;
    m->rate = 0.0;
    m->s[AT_TIME] = m->start;
    m->s[AT_PHASE] = m->start;
    m->s[AT_LONGEST] = m->max_step;
    m->s[AT_RTOL] = m->rtol;
    m->s[AT_ATOL] = m->atol;
    m->s[AT_SHORTEST] = @SHORTEST@ * (end - m->start);
    m->s[AT_SPAN] = end - m->start;
    m->fresh = true;
    @BEGIN@
}

@GO_ON@
