/* Offers of WHEP peers. What is taken is bounded, is written as an offer that
 * is read again as the same, and is answered line by line. What follows a NUL
 * stands for GStreamer's answer. */
#include <glib.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "net/whepoffer.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

static size_t count(const char *text, const char *what)
{
    size_t n = 0;
    for (const char *at = text; (at = strstr(at, what)); at++) {
        n++;
    }
    return n;
}

static void look_at_offer(const struct pel_whep_offer *o, bool candidates)
{
    struct pel_whep_offer again;
    char *text = pel_whep_offer_write(o, candidates);
    demand(!pel_whep_offer_read(text, strlen(text), &again, NULL));
    demand(again.line_count == 1 && again.video == 0 &&
           again.payload == o->payload && again.vp8 == o->vp8 &&
           again.rtx == o->rtx);
    demand(strcmp(again.transport.ufrag, o->transport.ufrag) == 0 &&
           strcmp(again.transport.password, o->transport.password) == 0 &&
           strcmp(again.transport.fingerprint, o->transport.fingerprint) == 0 &&
           strcmp(again.profile, o->profile) == 0);
    demand(again.transport.candidate_count ==
           (candidates ? o->transport.candidate_count : 0));
    for (size_t i = 0; i < again.transport.candidate_count; i++) {
        demand(strcmp(again.transport.candidates[i],
                      o->transport.candidates[i]) == 0);
    }
    g_free(text);
}

static void look_at_answer(const struct pel_whep_offer *o, const char *media)
{
    const uint32_t epoch = 7;
    char *text = pel_whep_answer_write(o, media, o->payload % 2 ? &epoch : 0);
    demand(!text == !strstr(media, "m=video"));
    demand(!text || count(text, "m=") >= o->line_count);
    /* All but the pictures', and data whose transport is shared. */
    demand(!text || count(text, "a=inactive\r\n") + 2 >= o->line_count);
    g_free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pel_whep_offer *offer = malloc(sizeof *offer);
    struct pel_fault fault = { 0 };
    const uint8_t *end = size ? memchr(data, 0, size) : NULL;
    size_t length = end ? (size_t)(end - data) : size;
    char *text = malloc(length + 1); /* ASan sees what is read beyond it */
    memcpy(text, data, length);
    if (end) {
        demand(pel_whep_offer_read((const char *)data, size, offer, NULL));
    }
    if (pel_whep_offer_read(text, length, offer, &fault)) {
        demand(fault.path[0] && fault.message[0]);
    } else {
        demand(offer->line_count >= 1 && offer->line_count <= PEL_WHEP_LINES &&
               offer->video < offer->line_count && offer->payload <= 127 &&
               offer->transport.candidate_count <= PEL_WHEP_CANDIDATES);
        look_at_offer(offer, false);
        look_at_offer(offer, true);
        char *media = end ? g_strndup((const char *)end + 1, size - length - 1)
                          : pel_whep_offer_write(offer, true);
        look_at_answer(offer, media);
        g_free(media);
    }
    free(text);
    free(offer);
    return 0;
}
