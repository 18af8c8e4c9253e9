
/* The values at the start, as after instantiation. */
static void reset(unit *i)
{
    @NAME@_motion *m = &i->now.m;
    (void)memset(&i->now, 0, sizeof i->now);
    @NAME@_defaults(m);
    for (int64_t k = 0; k < STATES; k++) {
        m->y[k] = first_state[k];
    }
    for (int64_t k = 0; k < @CAPS@_PARAMETERS; k++) {
        m->p[k] = first_parameters[k];
    }
    for (int64_t k = 0; k < @CAPS@_INPUTS; k++) {
        m->r[k] = first_inputs[k];
    }
    m->rtol = @RTOL@;
    m->atol = @ATOL@;
    m->limit = @LIMIT_OF@;
    fill_tables(m);
    i->now.at = NEW;
    i->now.unhoisted = true;
    i->now.unsettled = true;
}

static unit *instance(const char *name, const char *told_token, purpose what)
{
    unit *i = NULL;
    if ((told_token != NULL) && (strcmp(told_token, token) == 0) && ((what == STEPPED) || EXCHANGES)) {
        i = (unit *)calloc(1U, sizeof *i);
    }
    if (i != NULL) {
        i->what = what;
        (void)snprintf(i->name, sizeof i->name, "%s", (name != NULL) ? name : "");
        reset(i);
    }
    return i;
}

static status initialize(unit *i, bool tolerance_told, double tolerance, double start, bool stop_told, double stop)
{
    @NAME@_motion *m = &i->now.m;
    if (!permitted(i, NEW, "the beginning of initialization")) {
        return FAILED;
    }
    if (!isfinite(start) || (stop_told && !(stop > start)) || (tolerance_told && !(tolerance > 0.0))) {
        return failed(i, "Expected a stop after the start, and a tolerance above zero.");
    }
    if (tolerance_told) {
        m->rtol = tolerance;
        m->atol = tolerance;
    }
    m->start = start;
    i->now.time = start;
    i->now.stop = stop_told ? stop : (double)INFINITY;
    i->now.at = INITIALIZING;
    return DONE;
}

/* The motion begins: the simulator looks at its start, for both purposes. */
static status initialized(unit *i)
{
    @NAME@_motion *m = &i->now.m;
    if (!permitted(i, INITIALIZING, "the end of initialization")) {
        return FAILED;
    }
    if (!refresh(i)) {
        return FAILED;
    }
    const int begun = @NAME@_begin(m, isfinite(i->now.stop) ? i->now.stop : (m->start + fmax(1.0, spacing(m->start))), 2);
    if ((begun == @CAPS@_OPEN) || (begun == @CAPS@_WRONG)) {
        return failed(i, (begun == @CAPS@_OPEN) ? "Expected start values that meet the constraints." : "Expected admissible tolerances.");
    }
    i->now.known = m->end;
    look_ahead(i, m->start);
    choose(i);
    note_sides(i);
    if ((begun == @CAPS@_ON_THRESHOLD) && !leaves_threshold(i) && (i->what == STEPPED)) {
        return failed(i, "Expected a start beside the threshold of each event, got one on it from which numbers tell no way.");
    }
    if (!settled(i)) {
        return FAILED;
    }
    i->now.at = ((i->what == EXCHANGE) || i->event_mode) ? EVENTS_MODE : STEPS;
    return DONE;
}

/* The state after an event at which a step ended, if it is not there yet. */
static bool take_over(unit *i)
{
    const bool takes = i->now.pending;
    for (int64_t k = 0; (k < N) && takes; k++) {
        i->now.m.y[k] = i->now.next[k];
    }
    i->now.pending = false;
    return takes;
}

/* Where the motion ends next: a communication point; tables go on as they are. */
static void aim_at(unit *i, double end)
{
    @NAME@_motion *m = &i->now.m;
    const double span = isfinite(i->now.stop) ? (i->now.stop - m->start) : (end - m->start);
    take_over(i);
    if (i->now.changed) {
        seen_anew(i);
    }
    i->now.changed = false;
    look_ahead(i, end);
    m->s[AT_TIME] = fmax(m->s[AT_TIME], beside(i));
    m->end = end;
    for (int64_t k = m->stop; k < m->stop_count; k++) { /* a time at which rates turn that is the end belongs to the next step */
        const double close = @ULPS@.0 * spacing(end);
        m->end = (fabs(m->stops[k] - end) <= close) ? (end - (2.0 * close)) : m->end;
    }
    m->times[1] = end;
    m->times[2] = (double)INFINITY;
    m->s[AT_SAMPLE] = 0.0;
    m->s[AT_SPAN] = span;
    m->s[AT_SHORTEST] = @SHORTEST@ * span;
    m->fresh = true;
}

/* What a step came to: the time reached, and why it ended there. */
typedef struct {
    double time;
    bool event;
    bool terminated;
} reached;

/* Why a motion does not go on. */
static const char *why_not(int said)
{
    const char *text = "A mode of contacts follows that the unit does not have. Simulate it with kane.";
    if (said == @CAPS@_STUCK) {
        text = "No step is short enough, or a rate is not finite.";
    } else if (said == @CAPS@_UNDECIDED) {
        text = "Numbers alone do not tell how the motion goes on. Simulate it with kane.";
    } else {
        /* an unknown mode */
    }
    return text;
}

/* Steps to a communication point, or to the first event before it. */
static status step(unit *i, double from, double length, reached *to)
{
    @NAME@_motion *m = &i->now.m;
    const double end = from + length;
    to->time = i->now.time;
    if (!(length > 0.0) || !(fabs(from - i->now.time) <= (1e-9 * fmax(length, fabs(from))))) {
        return failed(i, "Expected a step of positive length from the time that was reached.");
    }
    if (!refresh(i)) {
        return FAILED;
    }
    int said = @CAPS@_LIMIT;
    aim_at(i, end);
    for (int64_t turn = 0; (turn < 1000000000) && (said < @CAPS@_END) && !to->event; turn++) {
        said = @NAME@_go_on(m);
        to->event = noted(i, said);
    }
    to->terminated = said == @CAPS@_EVENT;
    if (said >= @CAPS@_UNDECIDED) {
        return failed(i, why_not(said));
    }
    i->now.ended = to->terminated;
    i->now.time = ((said == @CAPS@_END) && !to->event) ? end : m->s[AT_TIME];
    to->time = i->now.time;
    return DONE;
}

/* What an update of discrete states came to. */
typedef struct {
    bool changed;
    bool ends;
    bool timed;
    double next;
} update;

static status updated(unit *i, update *to)
{
    @NAME@_motion *m = &i->now.m;
    status said = DONE;
    to->ends = i->now.ended;
    to->changed = take_over(i);
    if (to->changed && !settled(i)) {
        return FAILED;
    }
    if (i->what == EXCHANGE) {
        if (!refresh(i)) {
            return FAILED;
        }
        m->s[AT_TIME] = i->now.time;
        to->changed = to->changed || moved_back(i);
        look_ahead(i, i->now.time);
        said = acted(i, &to->changed, &to->ends);
    }
    i->now.ended = to->ends;
    to->timed = (m->stop < m->stop_count) || ((TURNING + PULSES) > 0 && !isfinite(i->now.stop));
    to->next = (m->stop < m->stop_count) ? m->stops[m->stop] : i->now.known;
    return said;
}

/* The end of a step of an importer's integrator. */
static status completed(unit *i, bool *event, bool *ends)
{
    *ends = i->now.ended;
    *event = is_off(i);
    unshift(i);
    choose(i);
    return DONE;
}

/* Copies of the numbers. */
static status keep(const unit *i, void **state)
{
    numbers *copy = (*state != NULL) ? (numbers *)*state : (numbers *)malloc(sizeof *copy);
    if (copy == NULL) {
        return failed(i, "There is no memory for a copy of the state.");
    }
    *copy = i->now;
    *state = copy;
    return DONE;
}

static status restore(unit *i, const void *state)
{
    if (state == NULL) {
        return failed(i, "Expected a state that was got before, got none.");
    }
    i->now = *(const numbers *)state;
    return DONE;
}

static status restored(const unit *i, const unsigned char *bytes, size_t size, void **state)
{
    if (size != sizeof(numbers)) {
        return failed(i, "Expected as many bytes as a state has.");
    }
    void *copy = malloc(sizeof(numbers));
    if (copy == NULL) {
        return failed(i, "There is no memory for a copy of the state.");
    }
    (void)memcpy(copy, bytes, size);
    *state = copy;
    return DONE;
}
