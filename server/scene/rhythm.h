/* Rhythms of lights: those of marks in the notation of charts (INT 1, section
 * P; IALA R0110, formerly E-110), and Morse signals. Where a chart's character
 * leaves durations open they are those of docs/lights.md. Pure functions. */
#pragma once

#include <stdbool.h>

#include "base/err.h"

enum pel_lamp_colour {
    PEL_LAMP_WHITE,
    PEL_LAMP_RED,
    PEL_LAMP_GREEN,
    PEL_LAMP_YELLOW,
    PEL_LAMP_BLUE,
    PEL_LAMP_COLOURS
};

#define PEL_RHYTHM_MOST 64 /* appearances of light in a period */
#define PEL_RHYTHM_COLOURS 4
#define PEL_RHYTHM_WHY 160

/* A period of a character. */
struct pel_rhythm {
    double period_s; /* 0: fixed */
    int count;       /* of lit[], in their order */
    struct {
        double from_s, to_s;
        int colour; /* index into colours */
    } lit[PEL_RHYTHM_MOST];
    int colour_count; /* 1 .. PEL_RHYTHM_COLOURS */
    enum pel_lamp_colour colours[PEL_RHYTHM_COLOURS];
    bool alternates; /* shows them in turn; else each in a sector of its own */
};

/* "Fl(2) R 10s", "Q(6)+LFl 15s", "Iso 4s", "F Y", "VQ", "Mo(A) 8s", "Al.WR 6s":
 * character, colours (none: white), period. INVALID: `why` says in words what
 * it must be, after the name of its field. */
PEL_CHECK enum pel_err pel_rhythm_parse(const char *text,
                                        struct pel_rhythm *out,
                                        char why[PEL_RHYTHM_WHY]);

/* What is lit so many seconds after a period began: index into its colours, -1:
 * nothing. */
int pel_rhythm_at(const struct pel_rhythm *rhythm, double seconds);

/* Morse code (ITU-R M.1677-1): a dash is three units, so is the gap between
 * letters; between words seven. Units of the whole text, 0: it is empty, -1: a
 * sign has no code (A to Z, 0 to 9, space and . , ? ' / : = + - have). */
int pel_morse_units(const char *text);
/* Whether it is lit so many units after it began. */
bool pel_morse_lit(const char *text, double units);
