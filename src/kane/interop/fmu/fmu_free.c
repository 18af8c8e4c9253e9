/* There are no constraints. */
static bool assembled(unit *i)
{
    (void)i;
    return true;
}

static bool is_off(const unit *i)
{
    (void)i;
    return false;
}

static bool moved_back(unit *i)
{
    (void)i;
    return false;
}

static void choose(unit *i)
{
    (void)i;
}

