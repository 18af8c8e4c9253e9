/* SPDX-License-Identifier: BSD-3-Clause */
/* A master without Python: two units of one source, model exchange by Euler's steps and co-simulation, states kept and gone back to. */
#include UNIT

static void heard(void *environment, int said, const char *category, const char *text)
{
    (void)environment;
    (void)said;
    (void)fprintf(stderr, "%s: %s\n", category, text);
}

int main(void)
{
    void *one = fmi3InstantiateCoSimulation("one", token, "", false, true, false, false, NULL, 0U, NULL, heard, NULL);
    void *two = fmi3InstantiateModelExchange("two", token, "", false, false, NULL, heard);
    void *none = fmi3InstantiateModelExchange("none", "another token", "", false, false, NULL, NULL);
    void *kept = NULL;
    double x[STATES + 1];
    double dx[STATES + 1];
    double z[INDICATORS + 1];
    bool event = false;
    bool ends = false;
    bool early = false;
    bool timed = false;
    double t = 0.0;
    double next = 0.0;
    int said = 0;
    if ((one == NULL) || (two == NULL) || (none != NULL)) {
        return 1;
    }
    said += fmi3EnterInitializationMode(one, false, 0.0, 0.0, false, 0.0);
    said += fmi3ExitInitializationMode(one);
    for (int k = 0; k < 5; k++) {
        if (k == 2) {
            said += fmi3GetFMUState(one, &kept);
            said += fmi3DoStep(one, 0.1 * (double)k, 0.1, false, &event, &ends, &early, &t);
            said += fmi3SetFMUState(one, kept);
            said += fmi3FreeFMUState(one, &kept);
        }
        said += fmi3DoStep(one, 0.1 * (double)k, 0.1, false, &event, &ends, &early, &t);
    }
    said += fmi3GetContinuousStates(one, x, (size_t)STATES);
    for (int k = 0; k < STATES; k++) {
        (void)printf("%.17g\n", x[k]);
    }
    said += fmi3EnterInitializationMode(two, true, 1e-6, 0.0, true, 1.0);
    said += fmi3ExitInitializationMode(two);
    said += fmi3UpdateDiscreteStates(two, &event, &ends, &early, &event, &timed, &next);
    said += fmi3EnterContinuousTimeMode(two);
    for (int k = 0; k < 1000; k++) {
        said += fmi3SetTime(two, 1e-4 * (double)k);
        said += fmi3GetContinuousStates(two, x, (size_t)STATES);
        said += fmi3GetContinuousStateDerivatives(two, dx, (size_t)STATES);
        for (int i = 0; i < STATES; i++) {
            x[i] += 1e-4 * dx[i];
        }
        said += fmi3SetContinuousStates(two, x, (size_t)STATES);
        said += fmi3GetEventIndicators(two, z, (size_t)INDICATORS);
        said += fmi3CompletedIntegratorStep(two, true, &event, &ends);
    }
    said += fmi3Terminate(one);
    said += fmi3Terminate(two);
    fmi3FreeInstance(one);
    fmi3FreeInstance(two);
    return said;
}
