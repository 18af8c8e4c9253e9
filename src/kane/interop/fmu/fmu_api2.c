
/* FMI 2.0: types and functions as the standard names them (https://github.com/modelica/fmi-standard/releases/tag/v2.0.4). */
typedef int fmi2_status;
typedef int fmi2_boolean;
typedef void (*fmi2_log)(void *environment, const char *name, fmi2_status said, const char *category, const char *text, ...);

typedef struct {
    fmi2_log logger;
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *what);
    void (*finished)(void *environment, fmi2_status said);
    void *environment;
} fmi2_callbacks;

typedef struct {
    fmi2_boolean again;
    fmi2_boolean ends;
    fmi2_boolean nominals;
    fmi2_boolean changed;
    fmi2_boolean timed;
    double next;
} fmi2_event_info;

static void say(const void *instance, int said, const char *category, const char *text)
{
    const unit *i = (const unit *)instance;
    fmi2_log log_message = NULL;
    (void)memcpy(&log_message, &i->logger, sizeof log_message);
    log_message(i->environment, i->name, said, category, "%s", text);
}

@PROTOTYPES@

EXPORTED const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

EXPORTED const char *fmi2GetVersion(void)
{
    return "2.0";
}

EXPORTED fmi2_status fmi2SetDebugLogging(void *c, fmi2_boolean on, size_t count, const char *const categories[])
{
    (void)count;
    (void)categories;
    ((unit *)c)->logs = on != 0;
    return DONE;
}

EXPORTED void *fmi2Instantiate(const char *name, int type, const char *told_token, const char *resources, const fmi2_callbacks *functions,
                               fmi2_boolean visible, fmi2_boolean logs)
{
    (void)resources;
    (void)visible;
    unit *i = instance(name, told_token, (type == 0) ? EXCHANGE : STEPPED);
    if ((functions != NULL) && (functions->logger != NULL)) {
        if (i != NULL) {
            i->logs = logs != 0;
            i->environment = functions->environment;
            (void)memcpy(&i->logger, &functions->logger, sizeof functions->logger);
            i->say = say;
        } else {
            functions->logger(functions->environment, name, (int)FAILED, "logStatusError", "%s",
                              NOT_MADE);
        }
    }
    return i;
}

EXPORTED void fmi2FreeInstance(void *c)
{
    free(c);
}

EXPORTED fmi2_status fmi2SetupExperiment(void *c, fmi2_boolean tolerance_told, double tolerance, double start, fmi2_boolean stop_told,
                                         double stop)
{
    unit *i = (unit *)c;
    const status said = initialize(i, tolerance_told != 0, tolerance, start, stop_told != 0, stop);
    if (said == DONE) {
        i->now.at = NEW;
    }
    return said;
}

EXPORTED fmi2_status fmi2EnterInitializationMode(void *c)
{
    unit *i = (unit *)c;
    if (!(i->now.stop > 0.0) && (i->now.m.start == 0.0)) {
        i->now.stop = (double)INFINITY; /* nobody set an experiment up */
    }
    return enter(i, NEW, INITIALIZING, "fmi2EnterInitializationMode");
}

EXPORTED fmi2_status fmi2ExitInitializationMode(void *c)
{
    return initialized((unit *)c);
}

EXPORTED fmi2_status fmi2Terminate(void *c)
{
    return enter((unit *)c, CONTINUOUS | STEPS | EVENTS_MODE | OVER, OVER, "fmi2Terminate");
}

EXPORTED fmi2_status fmi2Reset(void *c)
{
    reset((unit *)c);
    return DONE;
}

EXPORTED fmi2_status fmi2GetReal(void *c, const uint32_t references[], size_t count, double values[])
{
    return get_values((unit *)c, references, count, values);
}

EXPORTED fmi2_status fmi2SetReal(void *c, const uint32_t references[], size_t count, const double values[])
{
    return set_values((unit *)c, references, count, values);
}

@OTHER_TYPES@
EXPORTED fmi2_status fmi2GetFMUstate(void *c, void **state)
{
    return keep((const unit *)c, state);
}

EXPORTED fmi2_status fmi2SetFMUstate(void *c, void *state)
{
    return restore((unit *)c, state);
}

EXPORTED fmi2_status fmi2FreeFMUstate(void *c, void **state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return DONE;
}

EXPORTED fmi2_status fmi2SerializedFMUstateSize(void *c, void *state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(numbers);
    return DONE;
}

EXPORTED fmi2_status fmi2SerializeFMUstate(void *c, void *state, char bytes[], size_t size)
{
    if ((state == NULL) || (size < sizeof(numbers))) {
        return failed((unit *)c, "Expected a state, and room for its bytes.");
    }
    (void)memcpy(bytes, state, sizeof(numbers));
    return DONE;
}

EXPORTED fmi2_status fmi2DeSerializeFMUstate(void *c, const char bytes[], size_t size, void **state)
{
    return restored((const unit *)c, (const unsigned char *)bytes, size, state);
}

EXPORTED fmi2_status fmi2GetDirectionalDerivative(void *c, const uint32_t unknowns[], size_t rows, const uint32_t knowns[], size_t columns,
                                                  const double seed[], double out[])
{
    return along((unit *)c, unknowns, rows, knowns, columns, seed, out);
}

EXPORTED fmi2_status fmi2EnterEventMode(void *c)
{
    return enter((unit *)c, CONTINUOUS | EVENTS_MODE, EVENTS_MODE, "fmi2EnterEventMode");
}

EXPORTED fmi2_status fmi2EnterContinuousTimeMode(void *c)
{
    return enter((unit *)c, EVENTS_MODE, CONTINUOUS, "fmi2EnterContinuousTimeMode");
}

EXPORTED fmi2_status fmi2NewDiscreteStates(void *c, fmi2_event_info *info)
{
    update to = {false, false, false, 0.0};
    if (!permitted((unit *)c, EVENTS_MODE, "fmi2NewDiscreteStates")) {
        return FAILED;
    }
    const status said = updated((unit *)c, &to);
    info->again = 0;
    info->ends = to.ends ? 1 : 0;
    info->nominals = 0;
    info->changed = to.changed ? 1 : 0;
    info->timed = to.timed ? 1 : 0;
    info->next = to.next;
    return said;
}

EXPORTED fmi2_status fmi2CompletedIntegratorStep(void *c, fmi2_boolean no_return, fmi2_boolean *event, fmi2_boolean *ends)
{
    bool asks = false;
    bool ended = false;
    (void)no_return;
    const status said = completed((unit *)c, &asks, &ended);
    *event = asks ? 1 : 0;
    *ends = ended ? 1 : 0;
    return said;
}

EXPORTED fmi2_status fmi2SetTime(void *c, double t)
{
    ((unit *)c)->now.time = t;
    return DONE;
}

EXPORTED fmi2_status fmi2SetContinuousStates(void *c, const double states[], size_t count)
{
    return put_states((unit *)c, states, count);
}

EXPORTED fmi2_status fmi2GetContinuousStates(void *c, double states[], size_t count)
{
    return get_states((unit *)c, states, count);
}

EXPORTED fmi2_status fmi2GetDerivatives(void *c, double derivatives[], size_t count)
{
    return get_slopes((unit *)c, derivatives, count);
}

EXPORTED fmi2_status fmi2GetEventIndicators(void *c, double indicators[], size_t count)
{
    return get_indicators((unit *)c, indicators, count);
}

EXPORTED fmi2_status fmi2GetNominalsOfContinuousStates(void *c, double nominals[], size_t count)
{
    return get_nominals((unit *)c, nominals, count);
}

EXPORTED fmi2_status fmi2SetRealInputDerivatives(void *c, const uint32_t references[], size_t count, const int orders[],
                                                 const double values[])
{
    (void)references;
    (void)orders;
    (void)values;
    return none_of((unit *)c, count);
}

EXPORTED fmi2_status fmi2GetRealOutputDerivatives(void *c, const uint32_t references[], size_t count, const int orders[], double values[])
{
    (void)references;
    (void)orders;
    (void)values;
    return none_of((unit *)c, count);
}

EXPORTED fmi2_status fmi2DoStep(void *c, double from, double length, fmi2_boolean no_return)
{
    reached to = {from, false, false};
    (void)no_return;
    if (!permitted((unit *)c, STEPS, "fmi2DoStep")) {
        return FAILED;
    }
    const status said = step((unit *)c, from, length, &to);
    return ((said == DONE) && to.terminated) ? (fmi2_status)DISCARDED : (fmi2_status)said;
}

EXPORTED fmi2_status fmi2CancelStep(void *c)
{
    return failed((unit *)c, "Steps are not asynchronous.");
}

EXPORTED fmi2_status fmi2GetStatus(void *c, int kind, fmi2_status *value)
{
    (void)c;
    (void)kind;
    *value = DONE;
    return DISCARDED;
}

EXPORTED fmi2_status fmi2GetRealStatus(void *c, int kind, double *value)
{
    *value = ((unit *)c)->now.time;
    return (kind == 2) ? DONE : DISCARDED;
}

EXPORTED fmi2_status fmi2GetIntegerStatus(void *c, int kind, int *value)
{
    (void)c;
    (void)kind;
    *value = 0;
    return DISCARDED;
}

EXPORTED fmi2_status fmi2GetBooleanStatus(void *c, int kind, fmi2_boolean *value)
{
    *value = ((unit *)c)->now.ended ? 1 : 0;
    return (kind == 3) ? DONE : DISCARDED;
}

EXPORTED fmi2_status fmi2GetStringStatus(void *c, int kind, const char **value)
{
    (void)c;
    (void)kind;
    *value = "";
    return DISCARDED;
}
