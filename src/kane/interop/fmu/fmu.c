
/*
 * The functional mock-up unit: the motion above behind the interface of FMI. An instance is allocated when it is made and freed when it
 * is given back, as are copies of its numbers; nothing else is allocated. Instances do not share anything that changes.
 */
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
#else
#define EXPORTED
#endif

static const char token[] = "@TOKEN@";

#define EXCHANGES @EXCHANGES@ /* whether it is for model exchange too */
#define NOT_MADE "Expected the token of modelDescription.xml, @AND_STEPS@and memory, got something else."

enum {
    STATES = @CAPS@_STATES,
    DER = 1 + STATES, /* value references: 0 is time; then come states, their derivatives, parameters, inputs, outputs, indicators */
    PARAMETER = DER + STATES,
    INPUT = PARAMETER + @CAPS@_PARAMETERS,
    OUTPUT = INPUT + @CAPS@_INPUTS,
    INDICATOR = OUTPUT + @OUTPUTS@,
    REFERENCES = INDICATOR + @INDICATORS@,
    OUTPUTS = @OUTPUTS@,
    INDICATORS = @INDICATORS@,
    ACTIONS = @ACTIONS@,
    KNOWNS = STATES + @CAPS@_INPUTS
};

static const double first_state[STATES + 1] = {@STATE@0.0};
static const double first_parameters[@CAPS@_PARAMETERS + 1] = {@PARAMETERS@0.0};
static const double first_inputs[@CAPS@_INPUTS + 1] = {@INPUTS@0.0};

typedef enum { DONE = 0, WARNING = 1, DISCARDED = 2, FAILED = 3 } status;
typedef enum { NEW = 1, INITIALIZING = 2, STEPS = 4, EVENTS_MODE = 8, CONTINUOUS = 16, OVER = 32 } mode;
typedef enum { EXCHANGE, STEPPED } purpose;

/* All that changes: numbers alone, so that a copy is the state of the unit. */
typedef struct {
    @NAME@_motion m;
    double time;
    double stop; /* of the experiment; infinite where none is told */
    double known; /* times at which rates turn are known up to here */
    double was[INDICATORS + 1]; /* the sides of the indicators */
    double shift[INDICATORS + 1]; /* what is added to an indicator until it has left zero after its event */
    double next[N]; /* where a step ended at an event: the state after it */
    mode at;
    bool touched[STATES + 1]; /* start values that were set */
    bool unhoisted; /* parameters changed */
    bool unsettled; /* start values changed */
    bool changed; /* what rates depend on changed since the last step */
    bool pending; /* `next` is to be taken over */
    bool ended; /* an event ended the motion */
} numbers;

typedef struct {
    numbers now;
    purpose what;
    bool logs;
    bool event_mode;
    bool early;
    void *environment;
    void (*say)(const void *instance, int said, const char *category, const char *text);
    void *logger;
    char name[256];
} unit;

/* Writes a message where the importer wants them; errors always. */
static status told(const unit *i, status said, const char *category, const char *text)
{
    if ((i->say != NULL) && (i->logs || (said >= FAILED))) {
        i->say(i, (int)said, category, text);
    }
    return said;
}

static status failed(const unit *i, const char *text)
{
    return told(i, FAILED, "logStatusError", text);
}

/* Whether a function may be called now. */
static bool permitted(const unit *i, int modes, const char *function)
{
    char text[160];
    const bool fine = (i != NULL) && (((int)i->now.at & modes) != 0);
    if ((i != NULL) && !fine) {
        (void)snprintf(text, sizeof text, "Expected %s in another mode, got it in mode %d.", function, (int)i->now.at);
        (void)failed(i, text);
    }
    return fine;
}

/* The time for rates in continuous time: on this side of the next time at which they turn, beyond the last one. */
static double beside(const unit *i)
{
    const @NAME@_motion *m = &i->now.m;
    double t = i->now.time;
    if (m->stop < m->stop_count) {
        const double stop = m->stops[m->stop];
        t = fmin(t, stop - (@ULPS@.0 * spacing(stop)));
    }
    if ((m->stop > 0) && (m->stop <= m->stop_count)) {
        const double past = m->stops[m->stop - 1];
        t = fmax(t, past + ((4.0 * @ULPS@.0) * spacing(past)));
    }
    return t;
}

@FMU_HELD@
@FMU_ACTING@
/* Times at which rates turn, up to a time and beyond; those that are behind are passed by. */
static void look_ahead(unit *i, double until)
{
    @NAME@_motion *m = &i->now.m;
    const double end = m->end;
    if ((until > i->now.known) || (!isfinite(i->now.stop) && (until >= i->now.known))) {
        const double further = until + fmax(1.0, until - m->start);
        i->now.known = isfinite(i->now.stop) ? fmax(i->now.stop, until) : further;
        m->end = i->now.known;
        m->stop_count = 0;
        m->stop = 0;
        @STOPS_FOUND@
        m->end = end;
    }
    for (int64_t turn = 0; turn <= STOPS; turn++) {
        if ((m->stop >= m->stop_count) || (m->stops[m->stop] > i->now.time)) {
            break;
        }
        m->stop++;
    }
}

/* What follows from parameters and start values that were set; whether it does. */
static bool refresh(unit *i)
{
    @NAME@_motion *m = &i->now.m;
    bool fine = true;
    if (i->now.unhoisted) {
        fmu_hoist(m);
        i->now.unhoisted = false;
        if (((int)i->now.at & ((int)NEW | (int)INITIALIZING)) == 0) { /* rates turn at other times */
            i->now.known = -(double)INFINITY;
            look_ahead(i, i->now.time);
        }
    }
    if (i->now.unsettled && (i->now.at != NEW)) {
        i->now.unsettled = false;
        fine = assembled(i);
    }
    return fine;
}

/* The derivatives of the states; whether they are finite. */
static bool slopes(unit *i, double *out)
{
    @NAME@_motion *m = &i->now.m;
    double whole[N];
    bool fine = refresh(i);
    if (fine) {
        fmu_rates(m, beside(i), whole);
        for (int64_t k = 0; k < STATES; k++) {
            out[k] = whole[k];
            fine = fine && isfinite(whole[k]);
        }
    }
    return fine;
}

/* The value of a variable; the vectors that are made for it are kept in `room` for the next ones. */
typedef struct {
    double slopes[N];
    double outputs[OUTPUTS + 1];
    double indicators[INDICATORS + 1];
    bool sloped;
    bool put;
    bool watched;
} room;

static status value_of(unit *i, uint32_t reference, room *made, double *value)
{
    @NAME@_motion *m = &i->now.m;
    bool fine = refresh(i);
    if (reference >= (uint32_t)REFERENCES) {
        return failed(i, "Expected a value reference of a variable, got another one.");
    }
    const int64_t k = (int64_t)reference;
    if (k == 0) {
        *value = i->now.time;
    } else if (k < DER) {
        *value = m->y[k - 1];
    } else if (k < PARAMETER) {
        fine = fine && (made->sloped || slopes(i, made->slopes));
        made->sloped = fine;
        *value = made->slopes[k - DER];
    } else if (k < INPUT) {
        *value = m->p[k - PARAMETER];
    } else if (k < OUTPUT) {
        *value = m->r[k - INPUT];
    } else if (k < INDICATOR) {
        if (!made->put) {
            fmu_outputs(m, beside(i), made->outputs);
            made->put = true;
        }
        *value = made->outputs[k - OUTPUT];
    } else {
        if (!made->watched) {
            indicate(i, made->indicators);
            made->watched = true;
        }
        *value = made->indicators[k - INDICATOR] + i->now.shift[k - INDICATOR];
    }
    return fine ? DONE : told(i, DISCARDED, "logStatusDiscard", "A derivative is not finite, or constraints cannot be met.");
}

static status get_values(unit *i, const uint32_t *references, size_t count, double *values)
{
    static const room nothing_yet;
    room made = nothing_yet;
    status said = DONE;
    for (size_t k = 0; (k < count) && (said == DONE); k++) {
        said = value_of(i, references[k], &made, &values[k]);
    }
    return said;
}

static status set_values(unit *i, const uint32_t *references, size_t count, const double *values)
{
    @NAME@_motion *m = &i->now.m;
    const bool begins = (i->now.at == NEW) || (i->now.at == INITIALIZING);
    for (size_t n = 0; n < count; n++) {
        const int64_t k = (int64_t)references[n];
        if (!isfinite(values[n])) {
            return failed(i, "Expected finite values of variables, got one that is not.");
        }
        if ((k >= 1) && (k < DER) && (begins || (i->what == EXCHANGE))) {
            m->y[k - 1] = values[n];
            i->now.touched[k - 1] = begins;
            i->now.unsettled = i->now.unsettled || begins;
        } else if ((k >= PARAMETER) && (k < INPUT) && (i->now.at != CONTINUOUS)) {
            m->p[k - PARAMETER] = values[n];
            i->now.unhoisted = true;
            i->now.unsettled = begins || (i->what == STEPPED);
        } else if ((k >= INPUT) && (k < OUTPUT)) {
            m->r[k - INPUT] = values[n];
            i->now.unsettled = i->now.unsettled || begins;
        } else {
            return failed(i, "Expected a start value, a parameter outside continuous time, or an input to be set, got another variable.");
        }
    }
    i->now.changed = true;
    return DONE;
}

/* ∂(unknowns)/∂(knowns) · seed for derivatives and outputs by states and inputs. */
static status along(unit *i, const uint32_t *unknowns, size_t rows, const uint32_t *knowns, size_t columns, const double *seed, double *out)
{
    @NAME@_motion *m = &i->now.m;
    double by[KNOWNS + 1];
    static const double zero[KNOWNS + 1];
    (void)memcpy(by, zero, sizeof by);
    if (!refresh(i)) {
        return failed(i, "Expected a state that meets the constraints.");
    }
    for (size_t n = 0; n < columns; n++) {
        const int64_t k = (int64_t)knowns[n];
        if ((k >= 1) && (k < DER)) {
            by[k - 1] = seed[n];
        } else if ((k >= INPUT) && (k < OUTPUT)) {
            by[STATES + (k - INPUT)] = seed[n];
        } else {
            return failed(i, "Expected directional derivatives by states and inputs, got another variable.");
        }
    }
    double jac[(STATES * STATES) + 1];
    double jac_inputs[(STATES * @CAPS@_INPUTS) + 1];
    double jac_outputs[(OUTPUTS * KNOWNS) + 1];
    if (!fmu_jacobians(m, beside(i), jac, jac_inputs, jac_outputs)) {
        return failed(i, "There are no directional derivatives where contacts change their modes.");
    }
    for (size_t n = 0; n < rows; n++) {
        const int64_t k = (int64_t)unknowns[n];
        double sum = 0.0;
        if ((k >= DER) && (k < PARAMETER)) {
            for (int64_t j = 0; j < STATES; j++) {
                sum += (by[j] != 0.0) ? (jac[((k - DER) * STATES) + j] * by[j]) : 0.0;
            }
            for (int64_t j = 0; j < @CAPS@_INPUTS; j++) {
                sum += jac_inputs[((k - DER) * @CAPS@_INPUTS) + j] * by[STATES + j];
            }
        } else if ((k >= OUTPUT) && (k < INDICATOR)) {
            for (int64_t j = 0; j < KNOWNS; j++) {
                sum += (by[j] != 0.0) ? (jac_outputs[((k - OUTPUT) * KNOWNS) + j] * by[j]) : 0.0;
            }
        } else if ((k >= 1) && (k < DER)) {
            sum = by[k - 1];
        } else {
            return failed(i, "Expected directional derivatives of states, their derivatives and outputs, got another variable.");
        }
        if (!isfinite(sum)) {
            return failed(i, "A derivative is not finite here.");
        }
        out[n] = sum;
    }
    return DONE;
}

static status enter(unit *i, int from, mode to, const char *function)
{
    if (!permitted(i, from, function)) {
        return FAILED;
    }
    i->now.at = to;
    return DONE;
}

/* For variables of types that there are none of. */
static status none_of(const unit *i, size_t count)
{
    return (count == 0U) ? DONE : failed(i, "All variables are Float64 (Real), and have no derivatives to ask for.");
}

static status put_states(unit *i, const double *states, size_t count)
{
    if (count != (size_t)STATES) {
        return failed(i, "Expected as many states as there are.");
    }
    for (int64_t k = 0; k < STATES; k++) {
        i->now.m.y[k] = states[k];
    }
    return DONE;
}

static status get_states(unit *i, double *states, size_t count)
{
    if ((count != (size_t)STATES) || !refresh(i)) {
        return failed(i, "Expected as many states as there are, which meet the constraints.");
    }
    for (int64_t k = 0; k < STATES; k++) {
        states[k] = i->now.m.y[k];
    }
    return DONE;
}

static status get_slopes(unit *i, double *derivatives, size_t count)
{
    if (count != (size_t)STATES) {
        return failed(i, "Expected as many derivatives as there are states.");
    }
    return slopes(i, derivatives) ? DONE : told(i, DISCARDED, "logStatusDiscard", "A derivative is not finite.");
}

static status get_indicators(unit *i, double *indicators, size_t count)
{
    if ((count != (size_t)INDICATORS) || !refresh(i)) {
        return failed(i, "Expected as many indicators as there are events.");
    }
    indicate(i, indicators);
    for (int64_t k = 0; k < INDICATORS; k++) {
        indicators[k] += i->now.shift[k];
    }
    return DONE;
}

static status get_nominals(unit *i, double *nominals, size_t count)
{
    if (count != (size_t)STATES) {
        return failed(i, "Expected as many nominal values as there are states.");
    }
    for (int64_t k = 0; k < STATES; k++) {
        nominals[k] = 1.0;
    }
    return DONE;
}
