
#ifndef @CAPS@_NO_MAIN
/*
 * The program: compile this file, cc -std=c99 -O2 @NAME@.c -o @NAME@ -lm, and run
 *     ./@NAME@ END SAMPLES name=value ...
 * with a value for each of the state at the start and each input, and for parameters that are other than their defaults;
 * rtol=, atol= (1e-9) and max_step= besides. It prints time and state, a line a sample.
 */

/* Puts the value of name=value into its place; whether there is one. */
static bool put(const @NAME@_quantity *known, int64_t count, double *values, const char *text, size_t length, double value)
{
    bool found = false;
    for (int64_t k = 0; (k < count) && !found; k++) {
        if ((strlen(known[k].name) == length) && (strncmp(known[k].name, text, length) == 0)) {
            values[k] = value;
            found = true;
        }
    }
    return found;
}

/* Whether each has a value. */
static bool complete(const @NAME@_quantity *known, int64_t count, const double *values)
{
    for (int64_t k = 0; k < count; k++) {
        if (!isfinite(values[k])) {
            (void)fprintf(stderr, "Expected a value for %s, got none: pass %s=value.\n", known[k].name, known[k].name);
            return false;
        }
    }
    return true;
}

/* Whether a text is a finite number, and which one. */
static bool told(const char *text, double *number)
{
    char *end;
    *number = strtod(text, &end);
    return (end != text) && (*end == '\0') && isfinite(*number);
}

static void print_row(double t, const double *y)
{
    (void)printf("\n%.17g", t);
    for (int64_t k = 0; k < @CAPS@_STATES; k++) {
        (void)printf(",%.17g", y[k]);
    }
}

@REPORT@
/* The values that were given; whether all are known, and there is one for each that has no default. */
static bool filled(@NAME@_motion *m, int count, char **given)
{
    static const @NAME@_quantity settings[] = {{"rtol", "", "", 0.0}, {"atol", "", "", 0.0}, {"max_step", "", "", 0.0}};
    double set[] = {m->rtol, m->atol, m->max_step};
    for (int k = 3; k < count; k++) {
        const char *text = given[k];
        const size_t length = strcspn(text, "=");
        double value = 0.0;
        if ((text[length] != '=') || !told(&text[length + 1U], &value)) {
            (void)fprintf(stderr, "Expected name=value with a finite number, got %s.\n", text);
            return false;
        }
        if (!put(@NAME@_state, @CAPS@_STATES, m->y, text, length, value) &&
            !put(@NAME@_parameters, @CAPS@_PARAMETERS, m->p, text, length, value) &&
            !put(@NAME@_inputs, @CAPS@_INPUTS, m->r, text, length, value) && !put(settings, 3, set, text, length, value)) {
            (void)fprintf(stderr, "Expected a name of the state, the parameters or the inputs, got %s.\n", text);
            return false;
        }
    }
    m->rtol = set[0];
    m->atol = set[1];
    m->max_step = set[2];
    if (!((m->rtol > 0.0) && (m->atol > 0.0) && (m->max_step > 0.0))) {
        (void)fprintf(stderr, "Expected rtol, atol and max_step above zero%s.\n", @FIXED@ ? "; @METHOD@ needs max_step" : "");
        return false;
    }
    return complete(@NAME@_state, @CAPS@_STATES, m->y) && complete(@NAME@_parameters, @CAPS@_PARAMETERS, m->p)@COMPLETE@;
}

int main(int count, char **given)
{
    static @NAME@_motion room;
    @NAME@_motion *const m = &room;
    double end = 0.0;
    double number = 0.0;
    if ((count < 3) || !told(given[1], &end) || !(end > 0.0) || !told(given[2], &number) || !((number >= 2.0) && (number < 1e9))) {
        (void)fprintf(stderr, "Expected the time END > 0 and how many SAMPLES: %s END SAMPLES name=value ...\n", given[0]);
        return 2;
    }
    if (number > (double)@CAPS@_SAMPLES) {
        (void)fprintf(stderr, "Expected at most %d samples, got %.0f: compile with -D@CAPS@_SAMPLES=%.0f.\n", @CAPS@_SAMPLES, number, number);
        return 3;
    }
    @NAME@_defaults(m);
    if (!filled(m, count, given)) {
        return 2;
    }
    const int begun = @NAME@_begin(m, end, (int64_t)number);
    @SAY_BEGIN@
    if (begun != @CAPS@_BEGUN) {
        return 2;
    }
    (void)printf("t");
    for (int64_t k = 0; k < @CAPS@_STATES; k++) {
        (void)printf(",%s", @NAME@_state[k].name);
    }
    @FIRST_ROW@int said = @CAPS@_LIMIT;
    int64_t printed = 1;
    for (int64_t turn = 0; (turn < 1000000000) && (said < @CAPS@_END); turn++) {
        said = @NAME@_go_on(m);
        report(m, &printed);
        @SAY_CHANGES@
    }
    (void)printf("\n");
    for (int64_t k = 1; k < m->samples; k++) {
        if (m->marks[k - 1] > 0.0) {
            (void)fprintf(stderr, "The row at t = %.9g may be off its constraints, which are singular nearby.\n", m->times[k]);
        }
    }
    if (said == @CAPS@_UNDECIDED) {
        (void)fprintf(stderr, "The motion stopped at t = %.9g: numbers alone do not determine how it continues. Simulate it with kane.\n", m->s[AT_TIME]);
    }
    @SAY_UNKNOWN@if (said == @CAPS@_STUCK) {
        (void)fprintf(stderr, "The motion stopped at t = %.9g: no step is short enough, or a rate is not finite.\n", m->s[AT_TIME]);
    }
    return ((said == @CAPS@_END) || (said == @CAPS@_EVENT)) ? 0 : 1;
}
#endif
