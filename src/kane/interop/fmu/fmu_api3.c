
/* FMI 3.0: types and functions as the standard names them (https://fmi-standard.org/docs/3.0/). */
typedef int fmi3_status;
typedef void (*fmi3_log)(void *environment, fmi3_status said, const char *category, const char *text);

static void say(const void *instance, int said, const char *category, const char *text)
{
    const unit *i = (const unit *)instance;
    fmi3_log log_message = NULL;
    (void)memcpy(&log_message, &i->logger, sizeof log_message);
    log_message(i->environment, said, category, text);
}

static void *made(const char *name, const char *told_token, purpose what, bool logs, void *environment, fmi3_log log_message)
{
    unit *i = instance(name, told_token, what);
    if (i != NULL) {
        i->logs = logs;
        i->environment = environment;
        (void)memcpy(&i->logger, &log_message, sizeof log_message);
        i->say = (log_message != NULL) ? say : NULL;
    } else if (log_message != NULL) {
        log_message(environment, (int)FAILED, "logStatusError", NOT_MADE);
    } else {
        /* nobody to tell */
    }
    return i;
}

typedef void (*fmi3_intermediate)(void *environment, double t, bool set, bool get, bool finished, bool can_return, bool *early, double *at);

@PROTOTYPES@

EXPORTED const char *fmi3GetVersion(void)
{
    return "3.0";
}

EXPORTED fmi3_status fmi3SetDebugLogging(void *instance, bool on, size_t count, const char *const categories[])
{
    (void)count;
    (void)categories;
    ((unit *)instance)->logs = on;
    return DONE;
}

EXPORTED void *fmi3InstantiateModelExchange(const char *name, const char *told_token, const char *resources, bool visible, bool logs,
                                            void *environment, fmi3_log log_message)
{
    (void)resources;
    (void)visible;
    return made(name, told_token, EXCHANGE, logs, environment, log_message);
}

EXPORTED void *fmi3InstantiateCoSimulation(const char *name, const char *told_token, const char *resources, bool visible, bool logs,
                                           bool event_mode, bool early, const uint32_t required[], size_t count, void *environment,
                                           fmi3_log log_message, fmi3_intermediate intermediate)
{
    (void)resources;
    (void)visible;
    (void)required;
    (void)count;
    (void)intermediate;
    unit *i = (unit *)made(name, told_token, STEPPED, logs, environment, log_message);
    if (i != NULL) {
        i->event_mode = event_mode;
        i->early = early;
    }
    return i;
}

EXPORTED void *fmi3InstantiateScheduledExecution(const char *name, const char *told_token, const char *resources, bool visible, bool logs,
                                                 void *environment, fmi3_log log_message, void (*clock)(void *), void (*lock)(void),
                                                 void (*unlock)(void))
{
    (void)name;
    (void)told_token;
    (void)resources;
    (void)visible;
    (void)logs;
    (void)clock;
    (void)lock;
    (void)unlock;
    if (log_message != NULL) {
        log_message(environment, (int)FAILED, "logStatusError", "Expected model exchange or co-simulation, got scheduled execution.");
    }
    return NULL;
}

EXPORTED void fmi3FreeInstance(void *instance)
{
    free(instance);
}

EXPORTED fmi3_status fmi3EnterInitializationMode(void *instance, bool tolerance_told, double tolerance, double start, bool stop_told,
                                                 double stop)
{
    return initialize((unit *)instance, tolerance_told, tolerance, start, stop_told, stop);
}

EXPORTED fmi3_status fmi3ExitInitializationMode(void *instance)
{
    return initialized((unit *)instance);
}

EXPORTED fmi3_status fmi3EnterEventMode(void *instance)
{
    return enter((unit *)instance, CONTINUOUS | STEPS | EVENTS_MODE, EVENTS_MODE, "fmi3EnterEventMode");
}

EXPORTED fmi3_status fmi3EnterContinuousTimeMode(void *instance)
{
    return enter((unit *)instance, EVENTS_MODE, CONTINUOUS, "fmi3EnterContinuousTimeMode");
}

EXPORTED fmi3_status fmi3EnterStepMode(void *instance)
{
    return enter((unit *)instance, EVENTS_MODE, STEPS, "fmi3EnterStepMode");
}

EXPORTED fmi3_status fmi3Terminate(void *instance)
{
    return enter((unit *)instance, CONTINUOUS | STEPS | EVENTS_MODE | OVER, OVER, "fmi3Terminate");
}

EXPORTED fmi3_status fmi3Reset(void *instance)
{
    reset((unit *)instance);
    return DONE;
}

EXPORTED fmi3_status fmi3EnterConfigurationMode(void *instance)
{
    return failed((unit *)instance, "There are no structural parameters.");
}

EXPORTED fmi3_status fmi3ExitConfigurationMode(void *instance)
{
    return failed((unit *)instance, "There are no structural parameters.");
}

EXPORTED fmi3_status fmi3GetFloat64(void *instance, const uint32_t references[], size_t count, double values[], size_t numbers_given)
{
    (void)numbers_given;
    return get_values((unit *)instance, references, count, values);
}

EXPORTED fmi3_status fmi3SetFloat64(void *instance, const uint32_t references[], size_t count, const double values[], size_t numbers_given)
{
    (void)numbers_given;
    return set_values((unit *)instance, references, count, values);
}

@OTHER_TYPES@
EXPORTED fmi3_status fmi3GetBinary(void *instance, const uint32_t references[], size_t count, size_t sizes[], const uint8_t *values[],
                                   size_t numbers_given)
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)numbers_given;
    return none_of((unit *)instance, count);
}

EXPORTED fmi3_status fmi3SetBinary(void *instance, const uint32_t references[], size_t count, const size_t sizes[],
                                   const uint8_t *const values[], size_t numbers_given)
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)numbers_given;
    return none_of((unit *)instance, count);
}

EXPORTED fmi3_status fmi3GetClock(void *instance, const uint32_t references[], size_t count, bool values[])
{
    (void)references;
    (void)values;
    return none_of((unit *)instance, count);
}

EXPORTED fmi3_status fmi3SetClock(void *instance, const uint32_t references[], size_t count, const bool values[])
{
    (void)references;
    (void)values;
    return none_of((unit *)instance, count);
}

EXPORTED fmi3_status fmi3GetNumberOfVariableDependencies(void *instance, uint32_t reference, size_t *count)
{
    (void)reference;
    (void)count;
    return failed((unit *)instance, "Dependencies are those of modelDescription.xml.");
}

EXPORTED fmi3_status fmi3GetVariableDependencies(void *instance, uint32_t dependent, size_t elements[], uint32_t independents[],
                                                 size_t of_independents[], int kinds[], size_t count)
{
    (void)dependent;
    (void)elements;
    (void)independents;
    (void)of_independents;
    (void)kinds;
    (void)count;
    return failed((unit *)instance, "Dependencies are those of modelDescription.xml.");
}

EXPORTED fmi3_status fmi3GetFMUState(void *instance, void **state)
{
    return keep((const unit *)instance, state);
}

EXPORTED fmi3_status fmi3SetFMUState(void *instance, void *state)
{
    return restore((unit *)instance, state);
}

EXPORTED fmi3_status fmi3FreeFMUState(void *instance, void **state)
{
    (void)instance;
    free(*state);
    *state = NULL;
    return DONE;
}

EXPORTED fmi3_status fmi3SerializedFMUStateSize(void *instance, void *state, size_t *size)
{
    (void)instance;
    (void)state;
    *size = sizeof(numbers);
    return DONE;
}

EXPORTED fmi3_status fmi3SerializeFMUState(void *instance, void *state, uint8_t bytes[], size_t size)
{
    if ((state == NULL) || (size < sizeof(numbers))) {
        return failed((unit *)instance, "Expected a state, and room for its bytes.");
    }
    (void)memcpy(bytes, state, sizeof(numbers));
    return DONE;
}

EXPORTED fmi3_status fmi3DeserializeFMUState(void *instance, const uint8_t bytes[], size_t size, void **state)
{
    return restored((const unit *)instance, bytes, size, state);
}

EXPORTED fmi3_status fmi3GetDirectionalDerivative(void *instance, const uint32_t unknowns[], size_t rows, const uint32_t knowns[],
                                                  size_t columns, const double seed[], size_t seeds, double out[], size_t outs)
{
    (void)seeds;
    (void)outs;
    return along((unit *)instance, unknowns, rows, knowns, columns, seed, out);
}

EXPORTED fmi3_status fmi3GetAdjointDerivative(void *instance, const uint32_t unknowns[], size_t rows, const uint32_t knowns[],
                                              size_t columns, const double seed[], size_t seeds, double out[], size_t outs)
{
    (void)seeds;
    (void)outs;
    status said = DONE;
    for (size_t k = 0; (k < columns) && (said == DONE); k++) {
        out[k] = 0.0;
        for (size_t j = 0; (j < rows) && (said == DONE); j++) {
            const double one = 1.0;
            double entry = 0.0;
            said = along((unit *)instance, &unknowns[j], 1U, &knowns[k], 1U, &one, &entry);
            out[k] += seed[j] * entry;
        }
    }
    return said;
}

EXPORTED fmi3_status fmi3EvaluateDiscreteStates(void *instance)
{
    (void)instance;
    return DONE;
}

EXPORTED fmi3_status fmi3UpdateDiscreteStates(void *instance, bool *again, bool *ends, bool *nominals, bool *changed, bool *timed,
                                              double *next)
{
    update to = {false, false, false, 0.0};
    if (!permitted((unit *)instance, EVENTS_MODE, "fmi3UpdateDiscreteStates")) {
        return FAILED;
    }
    const status said = updated((unit *)instance, &to);
    *again = false;
    *ends = to.ends;
    *nominals = false;
    *changed = to.changed;
    *timed = to.timed;
    *next = to.next;
    return said;
}

EXPORTED fmi3_status fmi3CompletedIntegratorStep(void *instance, bool no_return, bool *event, bool *ends)
{
    (void)no_return;
    return completed((unit *)instance, event, ends);
}

EXPORTED fmi3_status fmi3SetTime(void *instance, double t)
{
    ((unit *)instance)->now.time = t;
    return DONE;
}

EXPORTED fmi3_status fmi3SetContinuousStates(void *instance, const double states[], size_t count)
{
    return put_states((unit *)instance, states, count);
}

EXPORTED fmi3_status fmi3GetContinuousStates(void *instance, double states[], size_t count)
{
    return get_states((unit *)instance, states, count);
}

EXPORTED fmi3_status fmi3GetContinuousStateDerivatives(void *instance, double derivatives[], size_t count)
{
    return get_slopes((unit *)instance, derivatives, count);
}

EXPORTED fmi3_status fmi3GetEventIndicators(void *instance, double indicators[], size_t count)
{
    return get_indicators((unit *)instance, indicators, count);
}

EXPORTED fmi3_status fmi3GetNominalsOfContinuousStates(void *instance, double nominals[], size_t count)
{
    return get_nominals((unit *)instance, nominals, count);
}

EXPORTED fmi3_status fmi3GetNumberOfEventIndicators(void *instance, size_t *count)
{
    (void)instance;
    *count = (size_t)INDICATORS;
    return DONE;
}

EXPORTED fmi3_status fmi3GetNumberOfContinuousStates(void *instance, size_t *count)
{
    (void)instance;
    *count = (size_t)STATES;
    return DONE;
}

EXPORTED fmi3_status fmi3GetOutputDerivatives(void *instance, const uint32_t references[], size_t count, const int32_t orders[],
                                              double values[], size_t numbers_given)
{
    (void)references;
    (void)orders;
    (void)values;
    (void)numbers_given;
    return none_of((unit *)instance, count);
}

EXPORTED fmi3_status fmi3DoStep(void *instance, double from, double length, bool no_return, bool *event, bool *ends, bool *early,
                                double *time_reached)
{
    (void)no_return;
    reached to = {from, false, false};
    if (!permitted((unit *)instance, STEPS, "fmi3DoStep")) {
        return FAILED;
    }
    const status said = step((unit *)instance, from, length, &to);
    *event = to.event;
    *ends = to.terminated;
    *early = to.event && (to.time < (from + length));
    *time_reached = to.time;
    return said;
}

EXPORTED fmi3_status fmi3ActivateModelPartition(void *instance, uint32_t clock, double at)
{
    (void)clock;
    (void)at;
    return failed((unit *)instance, "There are no model partitions.");
}
@CLOCKS@
