/* There are no events. */
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

static bool noted(unit *i, int said)
{
    (void)i;
    (void)said;
    return false;
}

static status acted(unit *i, bool *changed, bool *ends)
{
    (void)i;
    (void)changed;
    (void)ends;
    return DONE;
}

/* The motion begins as it is. */
static bool settled(unit *i)
{
    (void)i;
    return true;
}
