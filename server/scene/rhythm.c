#include "scene/rhythm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Durations where the notation leaves them open: docs/lights.md. */
#define QUICK_S 1.0 /* 60 a minute; very quick 120, ultra quick 240 */
#define QUICK_LIT 0.4
#define LONG_S 2.0
#define LEAST_FLASH_S 0.3
#define MOST_FLASH_S 1.0
#define GROUP_S 2.0 /* between flashes of a group, at most */
#define LEAST_GROUP_S 0.6
#define LEAST_FLASHING_S 1.2 /* fewer than 50 a minute */
#define INTERRUPTED_S 3.0
#define MORSE_S 0.5
#define LEAST_MORSE_S 0.15
#define MORSE_REST 5 /* units of eclipse at least */
#define MOST_PERIOD_S 300.0
#define MOST_GROUPS 4
#define MOST_WORD 16

enum kind { F, OC, ISO, FL, LFL, Q, VQ, UQ, IQ, IVQ, IUQ, MO };

/* The longer before what it begins with. */
static const struct {
    const char *name;
    enum kind kind;
} kinds[] = {
    { "LFl", LFL }, { "Fl", FL },   { "F", F },     { "Oc", OC },
    { "Iso", ISO }, { "IVQ", IVQ }, { "IUQ", IUQ }, { "IQ", IQ },
    { "VQ", VQ },   { "UQ", UQ },   { "Q", Q },     { "Mo", MO },
};

struct character {
    enum kind kind;
    int groups, group[MOST_GROUPS]; /* flashes; groups 0: none given */
    char word[MOST_WORD + 1];       /* of Mo */
    bool and_long;                  /* + LFl */
    double period_s;                /* 0: none given */
};

static const char *skip(const char *text)
{
    while (*text == ' ' || *text == '.') {
        text++;
    }
    return text;
}

/* Past `word`, or NULL. */
static const char *past(const char *text, const char *word)
{
    size_t length = strlen(word);
    return strncmp(text, word, length) == 0 ? text + length : NULL;
}

/* Flashes of "(2)", "(2+1)"; a word of "(A)". Past it, or NULL. */
static const char *read_group(const char *text, struct character *c)
{
    size_t length = strcspn(++text, ")");
    if (text[length] != ')' || length == 0) {
        return NULL;
    }
    if (c->kind == MO) {
        if (length > MOST_WORD) {
            return NULL;
        }
        memcpy(c->word, text, length);
        return pel_morse_units(c->word) > 0 ? text + length + 1 : NULL;
    }
    for (;; text++) {
        char *end;
        long n = *text >= '0' && *text <= '9' ? strtol(text, &end, 10) : 0;
        if (n < 1 || n > 20 || c->groups == MOST_GROUPS) {
            return NULL;
        }
        c->group[c->groups++] = (int)n;
        text = end;
        if (*text == ')') {
            return text + 1;
        }
        if (*text != '+') {
            return NULL;
        }
    }
}

static const char *read_colours(const char *text, struct pel_rhythm *out)
{
    static const struct {
        const char *name;
        enum pel_lamp_colour colour;
    } names[] = {
        { "W", PEL_LAMP_WHITE }, { "R", PEL_LAMP_RED },
        { "G", PEL_LAMP_GREEN }, { "Y", PEL_LAMP_YELLOW },
        { "Bu", PEL_LAMP_BLUE },
    };
    for (bool found = true; found;) {
        found = false;
        for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
            const char *after = past(text, names[i].name);
            if (after && !found && out->colour_count < PEL_RHYTHM_COLOURS) {
                out->colours[out->colour_count++] = names[i].colour;
                text = after;
                found = true;
            }
        }
    }
    if (out->colour_count == 0) {
        out->colours[out->colour_count++] = PEL_LAMP_WHITE;
    }
    return text;
}

/* Reads all of it; NULL, or what is wrong with it. */
static const char *read_character(const char *text, struct character *c,
                                  struct pel_rhythm *out)
{
    const char *after = past(text, "Al");
    out->alternates = after != NULL;
    text = skip(after ? after : text);
    after = NULL;
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0] && !after; i++) {
        after = past(text, kinds[i].name);
        c->kind = kinds[i].kind;
    }
    if (!after && !out->alternates) {
        return "begins with no class of light";
    }
    c->kind = after ? c->kind : F;
    text = after ? after : text;
    bool groups = c->kind == FL || c->kind == OC || c->kind == Q ||
                  c->kind == VQ || c->kind == UQ || c->kind == MO;
    if (*text == '(') {
        text = groups ? read_group(text, c) : NULL;
        if (!text) {
            return "has no such group";
        }
    }
    after = past(text, "+LFl");
    if (after) {
        c->and_long = true;
        text = after;
    }
    text = skip(read_colours(skip(text), out));
    if (*text) {
        char *end;
        c->period_s = *text >= '0' && *text <= '9' ? strtod(text, &end) : -1;
        if (!(c->period_s > 0 && c->period_s <= MOST_PERIOD_S)) {
            return "ends in what is no period of 0 to 300 s";
        }
        text = past(skip(end), "s");
        if (!text || *text) {
            return "has a period that does not end in s";
        }
    }
    return NULL;
}

static void add(struct pel_rhythm *out, double from_s, double to_s)
{
    if (out->count < PEL_RHYTHM_MOST) {
        out->lit[out->count].from_s = from_s;
        out->lit[out->count].to_s = to_s;
        out->lit[out->count++].colour = 0;
    }
}

/* What is lit becomes dark; the period still begins with what comes first. */
static void invert(struct pel_rhythm *out)
{
    for (int i = 0; i < out->count; i++) {
        double next =
            i + 1 < out->count ? out->lit[i + 1].from_s : out->period_s;
        out->lit[i].from_s = out->lit[i].to_s;
        out->lit[i].to_s = next;
    }
}

/* Groups of flashes, as far apart as the period allows up to GROUP_S, a third
 * of that lit; a group is followed by an eclipse one flash longer, the last by
 * two. */
static const char *flash_groups(const struct character *c,
                                struct pel_rhythm *out)
{
    int flashes = 0, rests = c->groups > 1 ? c->groups + 2 : 2;
    for (int i = 0; i < c->groups; i++) {
        flashes += c->group[i];
    }
    double apart_s = fmin(GROUP_S, out->period_s / (flashes + rests)), at_s = 0;
    if (apart_s < LEAST_GROUP_S) {
        return "has more flashes than its period has room for";
    }
    for (int i = 0; i < c->groups; i++) {
        for (int k = 0; k < c->group[i]; k++) {
            add(out, at_s, at_s + apart_s / 3);
            at_s += apart_s;
        }
        at_s += apart_s;
    }
    return NULL;
}

static const char *quick(const struct character *c, double each_s,
                         struct pel_rhythm *out)
{
    int flashes = c->groups ? c->group[0] : 1;
    bool interrupted = c->kind == IQ || c->kind == IVQ || c->kind == IUQ;
    if (interrupted) {
        flashes = (int)floor((out->period_s - INTERRUPTED_S) / each_s + 1e-9);
    } else if (!c->groups) {
        out->period_s = each_s;
    }
    if (flashes < 1 || flashes > PEL_RHYTHM_MOST - 1 || c->groups > 1) {
        return "has no such group";
    }
    for (int i = 0; i < flashes; i++) {
        add(out, i * each_s, (i + QUICK_LIT) * each_s);
    }
    double end_s = flashes * each_s;
    if (c->and_long) {
        add(out, end_s, end_s + LONG_S);
        end_s += LONG_S;
    }
    if ((c->groups || interrupted) && out->period_s < end_s + each_s) {
        return "has more flashes than its period has room for";
    }
    return NULL;
}

static const char *morse(const struct character *c, struct pel_rhythm *out)
{
    int units = pel_morse_units(c->word);
    double unit_s = fmin(MORSE_S, out->period_s / (units + MORSE_REST));
    if (c->word[0] == 0) {
        return "needs a letter, as Mo(A)";
    }
    if (unit_s < LEAST_MORSE_S) {
        return "has more signs than its period has room for";
    }
    for (int i = 0; i < units; i++) {
        if (!pel_morse_lit(c->word, i)) {
            continue;
        }
        if (i > 0 && pel_morse_lit(c->word, i - 1)) {
            out->lit[out->count - 1].to_s = (i + 1) * unit_s;
        } else {
            add(out, i * unit_s, (i + 1) * unit_s);
        }
    }
    return NULL;
}

/* One flash or eclipse a period. */
static const char *single(const struct character *c, struct pel_rhythm *out)
{
    double p = out->period_s;
    if (c->kind == FL && p < LEAST_FLASHING_S) {
        return "flashes 50 times a minute or more: that is Q";
    }
    if (c->kind == LFL && p <= 2 * LONG_S) {
        return "needs more than 4 s for a flash of 2 s";
    }
    add(out, 0,
        c->kind == FL    ? fmin(fmax(p / 10, LEAST_FLASH_S), MOST_FLASH_S)
        : c->kind == LFL ? LONG_S
        : c->kind == OC  ? p / 3
                         : p / 2);
    if (c->kind == OC) {
        invert(out);
    }
    return NULL;
}

static const char *lay_out(const struct character *c, struct pel_rhythm *out)
{
    switch (c->kind) {
    case F:
        add(out, 0, out->period_s);
        return NULL;
    case OC:
    case FL: {
        if (!c->groups) {
            return single(c, out);
        }
        const char *why = flash_groups(c, out);
        if (c->kind == OC) {
            invert(out);
        }
        return why;
    }
    case ISO:
    case LFL:
        return single(c, out);
    case Q:
    case IQ:
        return quick(c, QUICK_S, out);
    case VQ:
    case IVQ:
        return quick(c, QUICK_S / 2, out);
    case UQ:
    case IUQ:
        return quick(c, QUICK_S / 4, out);
    case MO:
        break;
    }
    return morse(c, out);
}

/* Each colour in its turn: a group's flashes, or the whole again. */
static const char *alternate(const struct character *c, struct pel_rhythm *out)
{
    int n = out->colour_count;
    if (n < 2 || c->kind == MO || c->kind == IQ || c->kind == IVQ ||
        c->kind == IUQ) {
        return "alternates nothing: Al needs two colours or more";
    }
    if (c->groups) {
        for (int i = 0; i < out->count; i++) {
            out->lit[i].colour = i % n;
        }
        return out->count % n == 0
                   ? NULL
                   : "has flashes that its colours do not share evenly";
    }
    int once = out->count;
    for (int k = 1; k < n; k++) {
        for (int i = 0; i < once; i++) {
            add(out, out->lit[i].from_s + k * out->period_s,
                out->lit[i].to_s + k * out->period_s);
            out->lit[out->count - 1].colour = k;
        }
    }
    out->period_s *= n;
    return NULL;
}

static const char *make(const char *text, struct pel_rhythm *out)
{
    struct character c = { 0 };
    const char *why = read_character(text, &c, out);
    bool steady = (c.kind == F && !out->alternates) ||
                  ((c.kind == Q || c.kind == VQ || c.kind == UQ) && !c.groups);
    if (why) {
        return why;
    }
    if (steady != (c.period_s <= 0)) {
        return steady ? "has a period, which such a light has none of"
                      : "needs a period, as 10s";
    }
    if (c.and_long && !(c.groups == 1 && (c.kind == Q || c.kind == VQ))) {
        return "has +LFl, which only Q(6) and VQ(6) have";
    }
    bool shared = out->alternates && !c.groups && !steady;
    out->period_s = shared ? c.period_s / out->colour_count : c.period_s;
    why = lay_out(&c, out);
    return why || !out->alternates ? why : alternate(&c, out);
}

enum pel_err pel_rhythm_parse(const char *text, struct pel_rhythm *out,
                              char why[PEL_RHYTHM_WHY])
{
    *out = (struct pel_rhythm){ 0 };
    const char *wrong = make(text, out);
    if (wrong) {
        snprintf(
            why, PEL_RHYTHM_WHY,
            "%s: write F, Fl, LFl, Oc, Iso, Q, VQ, UQ, IQ, Mo or Al, then "
            "W R G Y Bu, then the period, like Fl(2) R 10s or Q(6)+LFl 15s",
            wrong);
        return PEL_ERR_INVALID;
    }
    return PEL_OK;
}

int pel_rhythm_at(const struct pel_rhythm *r, double seconds)
{
    if (r->period_s <= 0) {
        return 0;
    }
    double at = seconds - r->period_s * floor(seconds / r->period_s);
    for (int i = 0; i < r->count; i++) {
        if (at >= r->lit[i].from_s && at < r->lit[i].to_s) {
            return r->lit[i].colour;
        }
    }
    return -1;
}
