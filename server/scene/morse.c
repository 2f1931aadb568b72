#include <ctype.h>
#include <math.h>
#include <string.h>

#include "scene/rhythm.h"

#define LETTER_GAP 3
#define WORD_GAP 7

static const char *code_of(char sign)
{
    static const char *const letters[] = {
        ".-",   "-...", "-.-.", "-..",  ".",   "..-.", "--.",  "....", "..",
        ".---", "-.-",  ".-..", "--",   "-.",  "---",  ".--.", "--.-", ".-.",
        "...",  "-",    "..-",  "...-", ".--", "-..-", "-.--", "--..",
    };
    static const char *const digits[] = {
        "-----", ".----", "..---", "...--", "....-",
        ".....", "-....", "--...", "---..", "----.",
    };
    static const struct {
        char sign;
        const char *code;
    } others[] = {
        { '.', ".-.-.-" },  { ',', "--..--" }, { '?', "..--.." },
        { '\'', ".----." }, { '/', "-..-." },  { ':', "---..." },
        { '=', "-...-" },   { '+', ".-.-." },  { '-', "-....-" },
    };
    unsigned char c = (unsigned char)toupper((unsigned char)sign);
    if (c >= 'A' && c <= 'Z') {
        return letters[c - 'A'];
    }
    if (c >= '0' && c <= '9') {
        return digits[c - '0'];
    }
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        if (others[i].sign == (char)c) {
            return others[i].code;
        }
    }
    return NULL;
}

/* Units until the text has ended; *lit: whether it is at `units`. */
static int go_through(const char *text, double units, bool *lit)
{
    int at = 0, gap = 0;
    *lit = false;
    for (; *text; text++) {
        const char *code = code_of(*text);
        if (*text == ' ') {
            gap = at > 0 ? WORD_GAP : 0;
            continue;
        }
        if (!code) {
            return -1;
        }
        at += gap;
        for (; *code; code++) {
            int length = *code == '-' ? 3 : 1;
            *lit = *lit || (units >= at && units < at + length);
            at += length + (code[1] != 0);
        }
        gap = LETTER_GAP;
    }
    return at;
}

int pel_morse_units(const char *text)
{
    bool lit;
    return go_through(text, 0, &lit);
}

bool pel_morse_lit(const char *text, double units)
{
    bool lit;
    return go_through(text, units, &lit) > 0 && lit;
}
