/* There are no indicators: no events, or contacts that decide what there is of them. */
static void indicate(unit *i, double *out)
{
    (void)i;
    (void)out;
}

static void note_sides(unit *i)
{
    (void)i;
}

static void unshift(unit *i)
{
    (void)i;
}

static void seen_anew(unit *i)
{
    (void)i;
}

static bool leaves_threshold(unit *i)
{
    (void)i;
    return false;
}

static status acted(unit *i, bool *changed, bool *ends)
{
    (void)i;
    (void)changed;
    (void)ends;
    return DONE;
}

