/* Requests on their way to answers: made on a thread of their own, as a sea of
 * FFT takes tens of milliseconds for a new moment, and kept until a frame
 * takes them along. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bridges/cigi_query.h"

struct pel_cigi_answers;

/* Without `threaded`, answers are there when pel_cigi_answers_ask returns. */
struct pel_cigi_answers *pel_cigi_answers_create(bool threaded);
void pel_cigi_answers_destroy(struct pel_cigi_answers *answers);

/* Asks `count` requests of one moment; everything is copied or referenced. They
 * are answered about that moment; where more than two moments of a sea of FFT
 * wait for the thread, about the newest, whose host frame the answers name.
 * Beyond PEL_BOUND_CIGI_WAITING requests whose answers are not sent the oldest
 * that wait go unanswered, and where none wait these. */
void pel_cigi_answers_ask(struct pel_cigi_answers *answers,
                          const struct pel_cigi_moment *moment,
                          const struct pel_cigi_packet *const *questions,
                          size_t count);

/* Begins a frame. The answers that the frame before took go with it (`sent`) or
 * are taken once more. */
void pel_cigi_answers_begin(struct pel_cigi_answers *answers, bool sent);

/* The oldest answer that is ready, valid until the next call here; NULL: none.
 * It stays the oldest until pel_cigi_answers_pop. */
const struct pel_cigi_packet *
pel_cigi_answers_peek(struct pel_cigi_answers *answers);
void pel_cigi_answers_pop(struct pel_cigi_answers *answers);

/* Requests that were not even asked: more than a moment may have. */
void pel_cigi_answers_lose(struct pel_cigi_answers *answers, size_t count);

/* Tells the log of what was dropped since it was told last, once a minute at
 * most; whether it did. */
bool pel_cigi_answers_tell(struct pel_cigi_answers *answers, int64_t now_ns);

/* Forgets what is ready and what is not: of a host that is gone. */
void pel_cigi_answers_clear(struct pel_cigi_answers *answers);

/* Since the creation: answers made, requests or answers that found no room. */
size_t pel_cigi_answers_made(const struct pel_cigi_answers *answers);
size_t pel_cigi_answers_dropped(const struct pel_cigi_answers *answers);
