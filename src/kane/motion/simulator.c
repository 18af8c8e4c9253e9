
/*
 * The motion: @METHOD@ from time 0 on. Compile this file alone, cc -std=c99 -O2 @NAME@.c -o @NAME@ -lm, and run
 *     ./@NAME@ END SAMPLES name=value ...
 * with a value for each of the state at the start and each input, and for parameters that are other than their defaults;
 * rtol=, atol= (1e-9) and max_step= besides. It prints time and state, a line a sample. Steps end where rates jump or bend at
 * times that parameters set, and where pulses of time begin, have their top, and end.
 */
#include <float.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
@PLACES@
    N = @CAPS@_STATES,
    TURNING = @TURNING@, /* so many quantities turn something where they come to a level; then come their slopes, then pulses */
    PULSES = @PULSES@,
    LOOKED_AT = @LOOKED_AT@, /* at so many times pulses are looked for */
    MOST_PULSES = @MOST_PULSES@
};

@KERNEL@
typedef struct {
    const double *levels;
    double start, period; /* a period of 0: levels do not come again */
    int64_t count, most;
} turning;
@LEVELS@

@TABLES@
static void clock_at(double t, double *y, double *p, double *r, double *h, double *out)
{
    @CLOCK@
}

typedef struct {
    double *times;
    size_t count, room;
} breakpoints;

/* Adds a time, if it lies within the motion; whether there was memory. */
static int add(breakpoints *to, double t, double end)
{
    if (!(t > 0 && t < end)) return 1;
    if (to->count == to->room) {
        double *more = realloc(to->times, 2 * (to->room + 8) * sizeof *more);
        if (!more) return 0;
        to->times = more;
        to->room = 2 * (to->room + 8);
    }
    to->times[to->count++] = t;
    return 1;
}

/* Where a quantity that is `at` in the beginning and has this slope comes to its levels. */
static int add_levels(breakpoints *to, const turning *of, double at, double slope, double end)
{
    const double low = fmin(at, at + slope * end), high = fmax(at, at + slope * end), period = of->period;
    const double first = period > 0 ? floor((low - of->start) / period) : 0;
    const double last = period > 0 ? floor((high - of->start) / period) : 0;
    if (slope == 0 || !isfinite(high - low) || (period > 0 && (last - first + 1) * (double)of->count > (double)of->most)) return 1;
    int64_t within = 0;
    for (int pass = 0; pass < 2; pass++)
        for (double k = first; k <= last; k++)
            for (int64_t i = 0; i < of->count; i++) {
                const double level = of->levels[i] + period * k;
                if (!(level >= low && level <= high)) continue;
                if (pass == 0)
                    within++;
                else if (within <= of->most && !add(to, (level - at) / slope, end))
                    return 0;
            }
    return 1;
}

static int compare(const void *one, const void *other)
{
    const double a = *(const double *)one, b = *(const double *)other;
    return (a > b) - (a < b);
}

/* The beginnings, tops and ends of pulses in values at times from 0 to the end; `sorted` is room for as many. */
static int add_pulses(breakpoints *to, double *values, double *sorted, double end)
{
    double largest = 0, middle;
    int64_t there = 0, runs = 0;
    for (int64_t i = 0; i < LOOKED_AT; i++) {
        if (!isfinite(values[i])) return 1;
        sorted[i] = values[i];
    }
    qsort(sorted, LOOKED_AT, sizeof *sorted, compare);
    middle = sorted[LOOKED_AT / 2];
    for (int64_t i = 0; i < LOOKED_AT; i++) largest = fmax(largest, values[i] = fabs(values[i] - middle));
    for (int64_t i = 0; i < LOOKED_AT; i++)
        if (values[i] > @RISEN@ * largest) {
            there++;
            runs += i == 0 || !(values[i - 1] > @RISEN@ * largest);
        }
    if ((double)there > @SHARE@ * LOOKED_AT || runs > MOST_PULSES) return 1;
    for (int64_t i = 0; i < LOOKED_AT; i++) {
        if (!(values[i] > @RISEN@ * largest)) continue;
        const int64_t first = i > 0 ? i - 1 : 0;
        int64_t top = i;
        for (; i < LOOKED_AT && values[i] > @RISEN@ * largest; i++)
            if (values[i] > values[top]) top = i;
        const int64_t places[3] = {first, top, i < LOOKED_AT ? i : LOOKED_AT - 1};
        for (int k = 0; k < 3; k++)
            if (!add(to, end * (double)places[k] / (LOOKED_AT - 1), end)) return 0;
    }
    return 1;
}

/* The times at which steps end, in order; whether there was memory. */
static int find_breakpoints(breakpoints *to, double *y, double *p, double *r, double *h, double end)
{
    double out[2 * TURNING + PULSES + 1] = {0}, *values = 0;
    int done = 1;
    clock_at(0, y, p, r, h, out);
    for (int64_t k = 1; (double)k * @PERIOD@ < end && done; k++) done = add(to, (double)k * @PERIOD@, end);
    for (int k = 0; k < TURNING && done; k++) done = add_levels(to, turnings + k, out[k], out[TURNING + k], end);
    if (PULSES && done) done = (values = malloc((size_t)(PULSES + 1) * LOOKED_AT * sizeof *values)) != 0;
    for (int64_t i = 0; PULSES && done && i < LOOKED_AT; i++) {
        clock_at(end * (double)i / (LOOKED_AT - 1), y, p, r, h, out);
        for (int64_t k = 0; k < PULSES; k++) values[k * LOOKED_AT + i] = out[2 * TURNING + k];
    }
    for (int64_t k = 0; k < PULSES && done; k++) done = add_pulses(to, values + k * LOOKED_AT, values + (int64_t)PULSES * LOOKED_AT, end);
    free(values);
    if (to->count) qsort(to->times, to->count, sizeof *to->times, compare);
    return done;
}

static double spacing(double t)
{
    return nextafter(t, HUGE_VAL) - t;
}

static void rates(double t, double *x, double *p, double *r, double *h, double *out)
{
    @RATES@
}

@CONSTRAINTS@
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

@CONTROL@
static void print_row(double t, const double *y)
{
    printf("\n%.17g", t);
    for (int k = 0; k < N; k++) printf(",%.17g", y[k]);
}

@REPORT@

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
    if (!complete(@NAME@_state, y) || !complete(@NAME@_parameters, p)) return 2;
    @ASK@
    if (!complete(@NAME@_inputs, r)) return 2;
    if (!(set[0] > 0 && set[1] > 0 && set[2] > 0)) {
        fprintf(stderr, "Expected rtol, atol and max_step above zero%s.\n", @FIXED@ ? "; @METHOD@ needs max_step" : "");
        return 2;
    }
    @NAME@_hoist(p, h);
    @BEGIN@
    double *times = malloc((size_t)(samples + 1) * sizeof *times);
    double *rows = malloc((size_t)(samples * N) * sizeof *rows);
    double *marks = calloc((size_t)samples, sizeof *marks), *work = calloc((size_t)(@WORK@ * N), sizeof *work);
    breakpoints stops = {0, 0, 0};
    if (!times || !rows || !work || !marks || !find_breakpoints(&stops, y, p, r, h, end)) {
        fprintf(stderr, "Expected memory for %lld samples, got none.\n", (long long)samples);
        return 3;
    }
    for (int64_t k = 0; k < samples; k++) times[k] = k == samples - 1 ? end : end * (double)k / (double)(samples - 1);
    times[samples] = HUGE_VAL; /* one more, after the end */
    memcpy(rows, y, sizeof y);
    s[AT_LONGEST] = set[2];
    s[AT_RTOL] = set[0];
    s[AT_ATOL] = set[1];
    s[AT_SHORTEST] = DBL_EPSILON * DBL_EPSILON * end;
    (void)none;
    s[AT_SPAN] = end;
    printf("t");
    for (int k = 0; k < N; k++) printf(",%s", @NAME@_state[k].name);
    print_row(0, y);
    int64_t back, printed = 1;
    for (size_t k = 0;; k++) { /* up to just before the next breakpoint, and on from just beyond it */
        while (k < stops.count && stops.times[k] <= s[AT_TIME]) k++;
        s[AT_END] = k < stops.count ? stops.times[k] - @ULPS@ * spacing(stops.times[k]) : end;
        s[AT_STEP] = @FIXED@ ? set[2] : 0;
        s[AT_FRESH] = 1;
        @ASK_AGAIN@
        do {
            back = @CALL@;
            report(s, times, rows, &printed);
        } while (back == @FULL@ || (back == @LOOK@ && @GOES_ON@));
        if (back != @END@ || k >= stops.count) break;
        s[AT_TIME] = s[AT_END] + 4 * @ULPS@ * spacing(s[AT_END]);
        s[AT_TIME_LAG] = 0;
    }
    printf("\n");
    for (int64_t k = 0; k < samples - 1; k++)
        if (marks[k] > 0) fprintf(stderr, "The row at t = %.9g may be off its constraints, which are singular nearby.\n", times[k + 1]);
    if (back == @LOOK@)
        fprintf(stderr, "The motion stopped at t = %.9g: numbers alone do not tell how it goes on. Simulate it with kane.\n", s[AT_TIME]);
    else if (back != @END@ && back != @EVENT@)
        fprintf(stderr, "The motion stopped at t = %.9g: no step is short enough, or a rate is not finite.\n", s[AT_TIME]);
    free(times);
    free(rows);
    free(work);
    free(marks);
    free(stops.times);
    return back == @END@ || back == @EVENT@ ? 0 : 1;
}
