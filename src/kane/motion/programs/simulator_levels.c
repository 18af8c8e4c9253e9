/* Where a quantity that is `at` at the start and has this slope comes to its levels. */
static void add_levels(@NAME@_motion *m, const turning *of, double at, double slope)
{
    const double there = at + (slope * (m->end - m->start));
    const double low = fmin(at, there);
    const double high = fmax(at, there);
    const bool again = of->period > 0.0;
    const double first = again ? floor((low - of->start) / of->period) : 0.0;
    const double last = again ? floor((high - of->start) / of->period) : 0.0;
    const double turns = (last - first) + 1.0;
    if ((slope == 0.0) || !isfinite(high - low) || ((turns * (double)of->count) > (double)of->most)) {
        return;
    }
    int64_t within = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int64_t k = 0; k < (int64_t)turns; k++) {
            for (int64_t i = 0; i < of->count; i++) {
                const double level = of->levels[i] + (of->period * (first + (double)k));
                const bool inside = (level >= low) && (level <= high);
                if (inside && (pass == 0)) {
                    within++;
                } else if (inside && (within <= of->most)) {
                    add_stop(m, m->start + ((level - at) / slope));
                } else {
                    /* outside, or there are too many */
                }
            }
        }
    }
}

