
/*
 * The motion: @METHOD@ from time 0 on. Compile this file alone, cc -std=c99 -O2 @NAME@.c -o @NAME@ -lm, and run
 *     ./@NAME@ END SAMPLES name=value ...
 * with a value for each of the state at the start and each input, and for parameters that are other than their defaults;
 * rtol=, atol= (1e-9) and max_step= besides. It prints time and state, a line a sample.
 */
#include <float.h>
#include <stdio.h>
#include <stdlib.h>

enum {
@PLACES@
    N = @CAPS@_STATES
};

static void rates(double t, double *x, double *p, double *r, double *h, double *out)
{
    @NAME@_rhs(t, x, p, r, h, out);
}

/* Puts the value of name=value into its place; whether there is one. */
static int put(const @NAME@_quantity *known, double *values, const char *text, size_t length, double value)
{
    for (int k = 0; known[k].name; k++)
        if (strlen(known[k].name) == length && strncmp(known[k].name, text, length) == 0) {
            values[k] = value;
            return 1;
        }
    return 0;
}

/* Whether each has a value. */
static int complete(const @NAME@_quantity *known, const double *values)
{
    for (int k = 0; known[k].name; k++)
        if (!isfinite(values[k])) {
            fprintf(stderr, "Expected a value for %s, got none: pass %s=value.\n", known[k].name, known[k].name);
            return 0;
        }
    return 1;
}

static int told(const char *text, double *number)
{
    char *end;
    *number = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*number);
}

int main(int count, char **given)
{
    double y[N], lag[N] = {0}, p[@CAPS@_PARAMETERS + 1], r[@CAPS@_INPUTS + 1], h[@CAPS@_HOISTED + 1] = {0};
    double s[@SIZE@] = {0}, none[@ARGUMENTS@][1] = {{0}}, end, number, value;
    if (count < 3 || !told(given[1], &end) || !(end > 0) || !told(given[2], &number) || !(number >= 2 && number < 1e9)) {
        fprintf(stderr, "Expected the time END > 0 and how many SAMPLES: %s END SAMPLES name=value ...\n", given[0]);
        return 2;
    }
    const int64_t samples = (int64_t)number;
    const @NAME@_quantity settings[] = {{"rtol", "", "", 0}, {"atol", "", "", 0}, {"max_step", "", "", 0}, {0, 0, 0, 0}};
    double set[3] = {1e-9, 1e-9, @FIXED@ ? NAN : HUGE_VAL};
    for (int k = 0; k < N; k++) y[k] = @NAME@_state[k].value;
    for (int k = 0; k < @CAPS@_PARAMETERS; k++) p[k] = @NAME@_parameters[k].value;
    for (int k = 0; k < @CAPS@_INPUTS; k++) r[k] = NAN;
    for (int k = 3; k < count; k++) {
        const char *sign = strchr(given[k], '=');
        const size_t length = sign ? (size_t)(sign - given[k]) : 0;
        if (!sign || !told(sign + 1, &value)) {
            fprintf(stderr, "Expected name=value with a finite number, got %s.\n", given[k]);
            return 2;
        }
        if (!put(@NAME@_state, y, given[k], length, value) && !put(@NAME@_parameters, p, given[k], length, value) &&
            !put(@NAME@_inputs, r, given[k], length, value) && !put(settings, set, given[k], length, value)) {
            fprintf(stderr, "Expected a name of the state, the parameters or the inputs, got %s.\n", given[k]);
            return 2;
        }
    }
    if (!complete(@NAME@_state, y) || !complete(@NAME@_parameters, p) || !complete(@NAME@_inputs, r)) return 2;
    if (!(set[0] > 0 && set[1] > 0 && set[2] > 0)) {
        fprintf(stderr, "Expected rtol, atol and max_step above zero%s.\n", @FIXED@ ? "; @METHOD@ needs max_step" : "");
        return 2;
    }
    double *times = malloc((size_t)(samples + 1) * sizeof *times);
    double *rows = malloc((size_t)(samples * N) * sizeof *rows);
    double *work = calloc((size_t)(@WORK@ * N), sizeof *work);
    if (!times || !rows || !work) {
        fprintf(stderr, "Expected memory for %lld samples, got none.\n", (long long)samples);
        return 3;
    }
    for (int64_t k = 0; k < samples; k++) times[k] = k == samples - 1 ? end : end * (double)k / (double)(samples - 1);
    times[samples] = HUGE_VAL; /* one more, after the end */
    memcpy(rows, y, sizeof y);
    @NAME@_hoist(p, h);
    s[AT_STEP] = @FIXED@ ? set[2] : end / 1024;
    s[AT_END] = end;
    s[AT_LONGEST] = set[2];
    s[AT_RTOL] = set[0];
    s[AT_ATOL] = set[1];
    s[AT_SHORTEST] = DBL_EPSILON * DBL_EPSILON * end;
    s[AT_FRESH] = 1;
    (void)none;
    const int64_t back = @CALL@;
    const int64_t done = 1 + (int64_t)s[AT_SAMPLE];
    printf("t");
    for (int k = 0; k < N; k++) printf(",%s", @NAME@_state[k].name);
    for (int64_t i = 0; i < done; i++) {
        printf("\n%.17g", times[i]);
        for (int k = 0; k < N; k++) printf(",%.17g", rows[i * N + k]);
    }
    printf("\n");
    if (back != @END@) fprintf(stderr, "The motion stopped at t = %.9g: no step is short enough, or a rate is not finite.\n", s[AT_TIME]);
    free(times);
    free(rows);
    free(work);
    return back == @END@ ? 0 : 1;
}
