/* Handlers of /v1/views for http_route.c, and what they share with it. */
#pragma once

#include "net/http_route.h"

struct pel_http_call {
    const struct pel_http_context *context;
    const struct pel_http_request *request;
    struct pel_http_target *target;
    struct pel_http_answer *answer;
};

void pel_http_get_views(const struct pel_http_call *call);
void pel_http_get_view(const struct pel_http_call *call);
void pel_http_put_view(const struct pel_http_call *call);
void pel_http_delete_view(const struct pel_http_call *call);
void pel_http_get_frame(const struct pel_http_call *call);
/* http_set.c */
void pel_http_get_frames(const struct pel_http_call *call);
void pel_http_get_mjpeg(const struct pel_http_call *call);
/* http_debrief.c */
void pel_http_get_recordings(const struct pel_http_call *call);
void pel_http_post_recording(const struct pel_http_call *call);
void pel_http_get_debrief(const struct pel_http_call *call);
void pel_http_post_debrief(const struct pel_http_call *call);
/* Makes the call one about the debrief's scene, where the place is of it;
 * false: answered, as there is none. */
bool pel_http_of_debrief(struct pel_http_context *context,
                         struct pel_http_call *call);
/* http_optics.c */
void pel_http_get_optics(const struct pel_http_call *call);
void pel_http_post_optics(const struct pel_http_call *call);
void pel_http_get_almanac(const struct pel_http_call *call);
void pel_http_get_soundings(const struct pel_http_call *call);
/* http_series.c */
void pel_http_get_spectrum(const struct pel_http_call *call);
void pel_http_get_series(const struct pel_http_call *call);
void pel_http_post_series(const struct pel_http_call *call);
/* http_preset.c */
void pel_http_get_presets(const struct pel_http_call *call);
void pel_http_get_preset(const struct pel_http_call *call);
void pel_http_put_preset(const struct pel_http_call *call);
void pel_http_post_preset(const struct pel_http_call *call);
void pel_http_delete_preset(const struct pel_http_call *call);
/* http_live.c */
void pel_http_get_live(const struct pel_http_call *call);
void pel_http_get_ts(const struct pel_http_call *call);
void pel_http_get_hls(const struct pel_http_call *call);
void pel_http_get_hls_file(const struct pel_http_call *call);
void pel_http_post_whep(const struct pel_http_call *call);
void pel_http_delete_whep(const struct pel_http_call *call);

/* Sets a scalar of a message by a parameter of its name: NOT_FOUND, INVALID. */
PEL_CHECK enum pel_err pel_http_number(ProtobufCMessage *message,
                                       const char *name, const char *text,
                                       struct pel_fault *fault);

/* http_session.c */
void pel_http_get_session(const struct pel_http_call *call);
/* http_exercise.c */
void pel_http_get_exercise(const struct pel_http_call *call);
void pel_http_post_exercise(const struct pel_http_call *call);
void pel_http_get_cluster(const struct pel_http_call *call);
void pel_http_put_place(const struct pel_http_call *call);
void pel_http_delete_place(const struct pel_http_call *call);
void pel_http_get_placed(const struct pel_http_call *call);
void pel_http_get_exercises(const struct pel_http_call *call);
void pel_http_get_one_exercise(const struct pel_http_call *call);
void pel_http_put_exercise(const struct pel_http_call *call);
void pel_http_delete_exercise(const struct pel_http_call *call);
void pel_http_get_facts(const struct pel_http_call *call);

/* Reads one parameter of a picture into a request. */
PEL_CHECK enum pel_err
pel_http_frame_parameter(Pelagos__FrameRequest *frame,
                         const struct pel_http_pair *pair,
                         struct pel_fault *fault);
/* By the ending of a file's name. */
Pelagos__FrameFormat pel_http_frame_format(const char *file);

/* http_body.c: the body as a message. */
PEL_CHECK enum pel_err pel_http_body(const struct pel_http_call *call,
                                     const ProtobufCMessageDescriptor *type,
                                     ProtobufCMessage **out,
                                     struct pel_fault *fault);
/* `{}` where there is none. */
PEL_CHECK enum pel_err
pel_http_body_if_any(const struct pel_http_call *call,
                     const ProtobufCMessageDescriptor *type,
                     ProtobufCMessage **out, struct pel_fault *fault);
PEL_CHECK enum pel_err pel_http_merge_body(const struct pel_http_call *call,
                                           Pelagos__Patch **out,
                                           struct pel_fault *fault);

/* http_body.c: answers with a message, taken over or copied, as JSON, which is
 * written later. */
void pel_http_message(struct pel_http_answer *answer, int status,
                      ProtobufCMessage *message, bool pretty);
void pel_http_copy(struct pel_http_answer *answer, int status,
                   const ProtobufCMessage *message);

/* Answers with JSON text; takes ownership of it. */
void pel_http_json(struct pel_http_answer *answer, int status, char *owned);

/* Answers with the whole state and its revision as entity tag. */
void pel_http_state(const struct pel_http_call *call);

/* Name of the view in the URL; the view itself, or NULL: answered with 404. */
const char *pel_http_view_name(const struct pel_http_call *call);
const Pelagos__View *pel_http_need_view(const struct pel_http_call *call);

void pel_http_refuse(const struct pel_http_call *call, int status,
                     const struct pel_fault *fault);

/* If-Match against the state's revision; false: answered with 412. */
bool pel_http_precondition(const struct pel_http_call *call);
