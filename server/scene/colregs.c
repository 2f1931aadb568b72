#include "scene/colregs.h"

#include <math.h>

/* A vessel laid out: what its lights' places share. */
struct layout {
    const struct pel_vessel *vessel;
    double deck_m;         /* above the waterline */
    double apart_m;        /* between lights in a vertical line: 2 (i) */
    struct pel_vec3 fore;  /* masthead light, or the only one */
    struct pel_vec3 after; /* second masthead light */
    struct pel_vec3 side;  /* port */
    struct pel_vec3 stern;
    struct pel_vec3 stack; /* uppermost of all-round lights in a line */
    struct pel_nav_light *out;
    size_t count;
};

double pel_colregs_deck(const struct pel_vessel *v)
{
    return fmin(0.35 * v->height_m, 0.06 * v->length_m + 0.5);
}

/* Annex I 2 (a), (c), (d): the least height of the masthead light. */
static double least_masthead(const struct layout *l)
{
    const struct pel_vessel *v = l->vessel;
    return v->length_m >= 20 ? l->deck_m + pel_clamp(v->breadth_m, 6, 12)
                             : l->deck_m + (v->length_m >= 12 ? 2.5 : 1.5);
}

static void place_masthead(struct layout *l)
{
    const struct pel_vessel *v = l->vessel;
    const struct pel_nav_places *d = &v->described;
    bool two = v->length_m >= 50;
    double least = least_masthead(l);
    l->fore = d->has_masthead
                  ? d->masthead
                  : (struct pel_vec3){ (two ? 0.4 : 0.1) * v->length_m, 0,
                                       two ? least : v->height_m };
    l->fore.z = fmax(l->fore.z, least);
    if (v->length_m >= 20) {
        l->fore.x = fmax(l->fore.x, two ? v->length_m / 4 : 0); /* 3 (a) */
    }
    /* 2 (a) ii, 2 (b): seen above the first from 1000 m before the stem; 3
     * (a). */
    double behind = fmin(v->length_m / 2, 100);
    double above = fmax(4.5, 1 + l->fore.z * behind / 1000);
    l->after = d->has_second
                   ? d->second
                   : (struct pel_vec3){ l->fore.x - behind, 0, v->height_m };
    l->after.x = fmin(l->after.x, l->fore.x - behind);
    l->after.z = fmax(l->after.z, l->fore.z + above);
}

static void place_others(struct layout *l)
{
    const struct pel_vessel *v = l->vessel;
    const struct pel_nav_places *d = &v->described;
    double mast = l->fore.z - l->deck_m;
    l->side = d->has_sides
                  ? d->side
                  : (struct pel_vec3){ 0.1 * v->length_m, v->breadth_m / 2,
                                       l->deck_m + mast / 2 };
    l->side.y = fabs(l->side.y);
    l->side.z = fmin(l->side.z, l->deck_m + 0.75 * mast); /* 2 (g) */
    if (v->length_m >= 20) {
        l->side.x = fmin(l->side.x, l->fore.x); /* 3 (b) */
    } else if (v->length_m < 12) {
        l->side.z = fmin(l->side.z, l->fore.z - 1); /* 2 (d) */
    }
    l->stern = d->has_stern
                   ? d->stern
                   : (struct pel_vec3){ -v->length_m / 2, 0, l->deck_m + 1 };
}

/* Room below the highest masthead light for so many all-round lights, the
 * lowest high enough: 2 (f) i, 2 (i). */
static void raise_for(struct layout *l, int lights)
{
    const struct pel_vessel *v = l->vessel;
    struct pel_vec3 *top = v->length_m >= 50 ? &l->after : &l->fore;
    double least =
        l->deck_m + (v->length_m >= 20 ? 4 : 2) + lights * l->apart_m;
    top->z = fmax(top->z, least);
    l->stack = *top;
    l->stack.z -= l->apart_m;
}

static void show(struct layout *l, enum pel_nav_kind kind,
                 enum pel_lamp_colour colour, double range_nm,
                 struct pel_vec3 at)
{
    if (l->count < PEL_NAV_MOST) {
        l->out[l->count++] =
            (struct pel_nav_light){ kind, colour, range_nm, at };
    }
}

/* Rule 22. */
static double masthead_nm(const struct layout *l)
{
    double length = l->vessel->length_m;
    return length >= 50 ? 6 : length >= 20 ? 5 : length >= 12 ? 3 : 2;
}

static double other_nm(const struct layout *l)
{
    return l->vessel->length_m >= 50 ? 3 : 2;
}

static void show_masthead(struct layout *l, int lights)
{
    struct pel_vec3 at = l->fore;
    for (int i = 0; i < lights; i++, at.z -= l->apart_m) {
        show(l, PEL_NAV_MASTHEAD, PEL_LAMP_WHITE, masthead_nm(l), at);
    }
    if (l->vessel->length_m >= 50) {
        show(l, PEL_NAV_MASTHEAD, PEL_LAMP_WHITE, masthead_nm(l), l->after);
    }
}

static void show_sides(struct layout *l)
{
    double range = l->vessel->length_m < 12 ? 1 : other_nm(l);
    struct pel_vec3 starboard = l->side;
    starboard.y = -starboard.y;
    show(l, PEL_NAV_PORT, PEL_LAMP_RED, range, l->side);
    show(l, PEL_NAV_STARBOARD, PEL_LAMP_GREEN, range, starboard);
    show(l, PEL_NAV_STERN, PEL_LAMP_WHITE, other_nm(l), l->stern);
}

/* One above the other, in a line. */
static void show_stack(struct layout *l, const enum pel_lamp_colour *colours,
                       int lights)
{
    struct pel_vec3 at = l->stack;
    for (int i = 0; i < lights; i++, at.z -= l->apart_m) {
        show(l, PEL_NAV_ALL_ROUND, colours[i], other_nm(l), at);
    }
}

/* Rule 30 (a), (b); Annex I 2 (k). */
static void show_anchor(struct layout *l)
{
    const struct pel_vessel *v = l->vessel;
    bool two = v->length_m >= 50;
    struct pel_vec3 fore = { 0.45 * v->length_m, 0,
                             l->deck_m + (two                 ? 6
                                          : v->length_m >= 12 ? 3
                                                              : 1) };
    show(l, PEL_NAV_ALL_ROUND, PEL_LAMP_WHITE, other_nm(l), fore);
    if (two) {
        struct pel_vec3 aft = l->stern;
        aft.z = fmin(fmax(aft.z, l->deck_m + 1), fore.z - 4.5);
        show(l, PEL_NAV_ALL_ROUND, PEL_LAMP_WHITE, other_nm(l), aft);
    }
}

/* Rule 23 (a), (d) i: below 12 m one all-round light for two. */
static void by_engine(struct layout *l, int lights)
{
    if (l->vessel->length_m >= 12 || lights > 1) {
        show_masthead(l, lights);
        show_sides(l);
        return;
    }
    show(l, PEL_NAV_ALL_ROUND, PEL_LAMP_WHITE, other_nm(l), l->fore);
    show_sides(l);
    l->count--; /* the sternlight */
}

/* Rule 24. */
static void tows(struct layout *l, bool astern)
{
    by_engine(l, astern && l->vessel->tow_m > 200 ? 3 : 2);
    if (astern) {
        struct pel_vec3 above = l->stern;
        above.z += l->apart_m;
        show(l, PEL_NAV_STERN, PEL_LAMP_YELLOW, other_nm(l), above);
    }
}

/* Rule 26, without gear beyond 150 m. */
static void fishes(struct layout *l, bool trawls)
{
    const enum pel_lamp_colour colours[] = { trawls ? PEL_LAMP_GREEN
                                                    : PEL_LAMP_RED,
                                             PEL_LAMP_WHITE };
    raise_for(l, 2);
    if (trawls && l->vessel->length_m >= 50) {
        show(l, PEL_NAV_MASTHEAD, PEL_LAMP_WHITE, masthead_nm(l), l->after);
    }
    show_stack(l, colours, 2);
    if (l->vessel->makes_way) {
        /* 2 (j) */
        l->side.z = fmin(l->side.z, l->stack.z - 3 * l->apart_m);
        show_sides(l);
    }
}

/* Rule 27 (a). */
static void not_commanded(struct layout *l)
{
    const enum pel_lamp_colour colours[] = { PEL_LAMP_RED, PEL_LAMP_RED };
    raise_for(l, 2);
    show_stack(l, colours, 2);
    if (l->vessel->makes_way) {
        show_sides(l);
    }
}

/* Rule 27 (b). */
static void restricted(struct layout *l)
{
    const enum pel_lamp_colour colours[] = { PEL_LAMP_RED, PEL_LAMP_WHITE,
                                             PEL_LAMP_RED };
    raise_for(l, 3);
    show_stack(l, colours, 3);
    if (l->vessel->makes_way) {
        show_masthead(l, 1);
        show_sides(l);
    } else if (l->vessel->anchored) {
        show_anchor(l);
    }
}

/* Rule 28. */
static void constrained(struct layout *l)
{
    const enum pel_lamp_colour colours[] = { PEL_LAMP_RED, PEL_LAMP_RED,
                                             PEL_LAMP_RED };
    raise_for(l, 3);
    by_engine(l, 1);
    show_stack(l, colours, 3);
}

/* Rule 29. */
static void pilots(struct layout *l)
{
    const enum pel_lamp_colour colours[] = { PEL_LAMP_WHITE, PEL_LAMP_RED };
    raise_for(l, 2);
    show_stack(l, colours, 2);
    if (l->vessel->anchored) {
        show_anchor(l);
    } else {
        show_sides(l);
    }
}

/* Rule 30 (d), (f): not below 12 m. */
static void grounded(struct layout *l)
{
    const enum pel_lamp_colour colours[] = { PEL_LAMP_RED, PEL_LAMP_RED };
    show_anchor(l);
    if (l->vessel->length_m >= 12) {
        raise_for(l, 2);
        show_stack(l, colours, 2);
    }
}

size_t pel_colregs_lights(const struct pel_vessel *v,
                          struct pel_nav_light out[PEL_NAV_MOST])
{
    struct layout l = { .vessel = v,
                        .deck_m = pel_colregs_deck(v),
                        .apart_m = v->length_m >= 20 ? 2 : 1,
                        .out = out };
    place_masthead(&l);
    place_others(&l);
    switch (v->status) {
    case PEL_NAV_ANCHOR:
        show_anchor(&l);
        break;
    case PEL_NAV_NOT_UNDER_COMMAND:
        not_commanded(&l);
        break;
    case PEL_NAV_RESTRICTED:
        restricted(&l);
        break;
    case PEL_NAV_CONSTRAINED:
        constrained(&l);
        break;
    case PEL_NAV_MOORED:
        break;
    case PEL_NAV_AGROUND:
        grounded(&l);
        break;
    case PEL_NAV_FISHING:
    case PEL_NAV_TRAWLING:
        fishes(&l, v->status == PEL_NAV_TRAWLING);
        break;
    case PEL_NAV_SAILING: /* rule 25 (a) */
    case PEL_NAV_TOWED:   /* rule 24 (e) */
        show_sides(&l);
        break;
    case PEL_NAV_TOWING:
    case PEL_NAV_PUSHING:
        tows(&l, v->status == PEL_NAV_TOWING);
        break;
    case PEL_NAV_PILOT:
        pilots(&l);
        break;
    case PEL_NAV_OARS: /* rule 25 (d) ii */
        show(&l, PEL_NAV_ALL_ROUND, PEL_LAMP_WHITE, other_nm(&l), l.fore);
        break;
    case PEL_NAV_ENGINE:
    case PEL_NAV_UNDEFINED:
        by_engine(&l, 1);
        break;
    }
    return l.count;
}
