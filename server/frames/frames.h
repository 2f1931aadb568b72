/* The frame path: turns requests and subscriptions into drawn, encoded
 * pictures. It owns the render thread (the only user of GL) and the encoder
 * threads; between them and the control thread are bounded queues only.
 *
 * Every function is called on the control thread (the GLib main context that
 * was the default at creation), and every callback runs there. Callbacks may
 * request, cancel, subscribe and unsubscribe, themselves too; they must not
 * destroy the frames. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "base/metrics.h"
#include "base/share.h"
#include "render/filtering.h"
#include "scene/scene.h"

struct pel_frames;

#define PEL_MAX_ENCODERS 64 /* threads */

struct pel_frames_options {
    const char *device; /* as pel_devices_options.list */
    const char *shader_dir;
    const char *shading; /* as pel_renderer_options */
    bool gl_debug;
    unsigned lose_after; /* as pel_renderer_options */
    int lose_only;       /* as pel_devices_options */
    bool lose_for_good;  /* as well */
    bool paper_form;     /* pel_filtering.paper */
    double max_fps;      /* cap of live views, 1..240 */
    double quality; /* scale of live views, 0.25..1; 0: as holds their rate */
    int encoder_threads; /* 0: about one a core; at most PEL_MAX_ENCODERS */
    /* H.264 by this GStreamer element; NULL or "auto": the best there is. */
    const char *video_encoder;
};

/* Starts the threads and waits until the GL context stands. */
PEL_CHECK enum pel_err pel_frames_create(const struct pel_frames_options *o,
                                         struct pel_scene *scene,
                                         struct pel_frames **out,
                                         struct pel_fault *fault);

/* Stops and joins the threads; outstanding requests end with CONFLICT, and
 * subscriptions are over without a call. Takes at most 3 s: false when a
 * thread hung (in a driver) and was left behind; then end by _exit, as the
 * driver's own exit handlers would meet it. NULL allowed. */
bool pel_frames_destroy(struct pel_frames *frames);

/* The end without waiting, on the control thread: outstanding requests end with
 * CONFLICT, subscriptions as if their views were deleted. True: nobody has a
 * subscription any more, and no callback is called from now on, so that
 * pel_frames_destroy may be called by any thread; else to be called again. */
bool pel_frames_retire(struct pel_frames *frames);

/* GL_RENDERER of the devices in use; until the next call. */
const char *pel_frames_device(const struct pel_frames *frames);

enum pel_codec {
    PEL_CODEC_PICTURE, /* as its format says */
    PEL_CODEC_H264,    /* an Annex B access unit of a stream */
    PEL_CODEC_VP8,     /* a frame of a stream */
};

/* An encoded picture, immutable and reference counted (any thread). */
struct pel_frame {
    char view[PEL_NAME_SIZE];
    uint64_t number;     /* the views of one frame share it; pictures that are
                          * asked for, all of one revision and time */
    uint64_t revision;   /* of the scene it shows */
    uint32_t host_frame; /* newest of a simulator host, 0: none leads */
    unsigned stale;      /* silent inputs, of enum pel_stale */
    bool in_ground;      /* the camera is below the seabed's surface */
    double time_s;       /* simulated */
    double exposure_ev;
    uint32_t width, height;
    uint32_t drawn_width, drawn_height; /* less where quality is less than 1 */
    enum pel_codec codec;
    Pelagos__FrameFormat format; /* of PEL_CODEC_PICTURE */
    bool key;                    /* can be shown without those before it */
    int64_t requested_ns, drawn_ns, encoded_ns; /* CLOCK_MONOTONIC */
    int64_t present_ns;       /* when the views of this frame are to be shown */
    uint64_t present_unix_ns; /* the same, as a seal has it; 0: none has */
    double render_ms, encode_ms;
    uint32_t device; /* that drew it, of the list of devices from 0 */
    const uint8_t *data;
    size_t size;
};
/* When it is to be shown, of a frame of now_ns by CLOCK_MONOTONIC, which is
 * unix_ns [us since 1970]: the same on all nodes where it is sealed. */
int64_t pel_frame_present_us(const struct pel_frame *frame, int64_t now_ns,
                             int64_t unix_ns);
struct pel_frame *pel_frame_ref(struct pel_frame *frame);
void pel_frame_unref(struct pel_frame *frame); /* NULL allowed */

/* frame is NULL when err is not PEL_OK; it is borrowed for the call. */
typedef void (*pel_frame_callback)(void *user, enum pel_err err,
                                   const struct pel_fault *fault,
                                   struct pel_frame *frame);

/* One picture, in memory at most PEL_FRAME_SET_BYTES before it is encoded. One
 * that would hold up others for longer than a frame of theirs is drawn in bands
 * between these. Refusals that can be known at once (no such view, unknown
 * layer, size out of range, more than 128 requests waiting: BUSY) are returned
 * and the callback is not called; otherwise it is called exactly once.
 * *id (may be NULL) names the request for pel_frames_cancel. */
PEL_CHECK enum pel_err pel_frames_request(struct pel_frames *frames,
                                          const Pelagos__FrameRequest *request,
                                          pel_frame_callback done, void *user,
                                          uint64_t *id,
                                          struct pel_fault *fault);

/* Names of the live views that somebody watches, each once, borrowed until the
 * loop runs again; their count. */
size_t pel_frames_watched(const struct pel_frames *frames,
                          const char *names[PEL_MAX_VIEWS]);

/* Whether such a picture may be asked for: the refusals of pel_frames_request
 * but BUSY. */
PEL_CHECK enum pel_err pel_frames_check(struct pel_frames *frames,
                                        const Pelagos__FrameRequest *request,
                                        struct pel_fault *fault);

/* The pictures of a set in the order of its requests; NULL with an error. They
 * are borrowed for the call. */
typedef void (*pel_frame_set_callback)(void *user, enum pel_err err,
                                       const struct pel_fault *fault,
                                       struct pel_frame *const *pictures,
                                       size_t count);

/* 1 to 64 pictures of one frame, in memory at most PEL_FRAME_SET_BYTES before
 * they are encoded: of one revision, simulated time and number, whatever else
 * happens meanwhile. All or none; otherwise as pel_frames_request. */
#define PEL_FRAME_SET_BYTES ((size_t)256 << 20)
PEL_CHECK enum pel_err
pel_frames_request_set(struct pel_frames *frames,
                       const Pelagos__FramesRequest *request,
                       pel_frame_set_callback done, void *user, uint64_t *id,
                       struct pel_fault *fault);

/* Says who has asked for a picture or a set: while an instructor or helmsman
 * watches a live view, pictures of lower ranks are encoded behind his. An id
 * that is unknown or finished is ignored. */
void pel_frames_rank(struct pel_frames *frames, uint64_t id,
                     enum pel_rank rank);

/* Cancels a request or a set: its callback is not called any more, and a
 * picture that no client waits for is neither drawn nor encoded further. An id
 * that is unknown or finished is ignored. */
void pel_frames_cancel(struct pel_frames *frames, uint64_t id);

/* A live view as JPEG: drawn only while someone is subscribed, encoded once
 * for each (view, quality), newest frame to all. The callback gets every frame;
 * dropping for slow clients is the subscriber's work. When the view is deleted
 * the callback gets NOT_FOUND once and no more frames; the subscription still
 * waits for pel_frames_unsubscribe. Any other error is of one frame only. At
 * most 256 subscriptions, 64 different (view, profile), and 67 million pixels
 * together, of which who may do less has less (base/share.h): BUSY, saying
 * which. Where all are taken one of a lower rank makes room for who steers or
 * instructs, and gets NOT_FOUND. quality 1..100. */
struct pel_subscription;
PEL_CHECK enum pel_err
pel_frames_subscribe(struct pel_frames *frames, const char *view, int quality,
                     pel_frame_callback on_frame, void *user,
                     struct pel_subscription **out, struct pel_fault *fault);
void pel_frames_unsubscribe(struct pel_subscription *subscription);

/* What a live view is encoded as. */
struct pel_profile {
    enum pel_codec codec;   /* PICTURE: JPEG */
    uint32_t width, height; /* 16..4096 px, 0: the view's */
    int quality;            /* of JPEG, 1..100 */
    unsigned kbps;          /* of video, 100..100000 kbit/s, 0: by the size */
    struct pel_who who;     /* in whose share it counts: no picture shows it */
};

/* As pel_frames_subscribe, in any profile: encoded once for each (view,
 * profile) whatever the number of subscribers. One of video begins
 * with a key frame, which is asked for at once (five a second at most), and
 * then gets every frame in order. Its callback gets NOT_FOUND too, once and
 * for good, when there is no encoder. OUT_OF_RANGE for a bad profile. */
PEL_CHECK enum pel_err pel_frames_open(struct pel_frames *frames,
                                       const char *view,
                                       const struct pel_profile *profile,
                                       pel_frame_callback on_frame, void *user,
                                       struct pel_subscription **out,
                                       struct pel_fault *fault);

/* Another profile from the next frame on. The only subscriber of an H.264
 * stream changes its rate in the running encoder; else the subscription moves
 * and begins with a key frame. Errors leave it as it was; CONFLICT when its
 * view is gone. */
PEL_CHECK enum pel_err pel_frames_change(struct pel_subscription *subscription,
                                         const struct pel_profile *profile,
                                         struct pel_fault *fault);

/* Counts it in another's share: one who may do more uses it too. */
void pel_frames_claim(struct pel_subscription *subscription,
                      const struct pel_who *who);

/* No frames until pel_frames_resync: nothing is drawn or encoded for those who
 * cannot take it. */
void pel_frames_pause(struct pel_subscription *subscription);

/* Goes on, in H.264 with the next key frame. `urgent` asks for that as a new
 * subscriber does; otherwise a stream is asked once a second at most. Also for
 * a subscriber that has lost frames. */
void pel_frames_resync(struct pel_subscription *subscription, bool urgent);

/* Asks for a key frame among the others; `urgent` as above. */
void pel_frames_want_key(struct pel_subscription *subscription, bool urgent);

/* The form of an answer. The threads that compute the answer write it slice by
 * slice; a form that is slow, for more than a slice, is written by one thread
 * behind those that draw, as 10,000 points take tens of milliseconds. Any
 * thread. */
#define PEL_SURFACE_HEAD 96
struct pel_surface_form {
    /* The samples from `first` on; malloc()ed. */
    char *(*slice)(const struct pel_surface_sample *samples, size_t first,
                   size_t count, size_t *size);
    /* Writes what comes before the slices, which are of `size` bytes together;
     * how long it is. */
    size_t (*head)(const struct pel_surface_form *form, double time_s,
                   size_t count, size_t size, char out[PEL_SURFACE_HEAD]);
    /* The text behind the slices; NULL: nothing. */
    const char *(*tail)(size_t count);
    bool slow;   /* slice() takes longer than what it writes took */
    bool has_id; /* of the reply, for head() */
    uint64_t id;
};

/* A query of the surface. */
struct pel_surface_wish {
    const struct pel_vec2 *points_m; /* copied */
    size_t count;                    /* at most 10,000 */
    bool has_time;                   /* else the clock's, or a moment near it
                                      * that was prepared (prefetch.h) */
    double time_s;
    bool moving;        /* accelerations too */
    bool foam;          /* its share too */
    const void *asker;  /* whose next query may be predicted; NULL: none */
    enum pel_rank rank; /* of who asks: from WATCH on little of the processors
                         * is used before pictures (surface_pool.h) */
    const struct pel_surface_form *form; /* copied; NULL: samples alone */
    uint64_t frame; /* 0: the present state; else the surface, and where no time
                     * is given the moment, of this frame: one of the last 64
                     * begun that show one of the last two seas */
};

/* Borrowed for the call. */
struct pel_surface_answer {
    double time_s;
    /* These and the text, by the wish's form, are malloc()ed: who keeps them
     * sets NULL. */
    struct pel_surface_sample *samples;
    size_t count;
    char *text;
    size_t size;
};

/* The surface off the control thread. At most 16 queries wait: BUSY;
 * NOT_FOUND: the frame. The answer is NULL with an error. */
typedef void (*pel_surface_callback)(void *user, enum pel_err err,
                                     const struct pel_fault *fault,
                                     struct pel_surface_answer *answer);
PEL_CHECK enum pel_err pel_frames_surface(struct pel_frames *frames,
                                          const struct pel_surface_wish *wish,
                                          pel_surface_callback done, void *user,
                                          struct pel_fault *fault);

/* Numbers of light, from the reference or from the device that draws, of the
 * present state or of what its patch would make of it. The numbers of the query
 * were tested (pel_command_check). The answer is borrowed for the call, NULL
 * with an error. At most 16 queries waiting: BUSY; faults as of a patch. */
typedef void (*pel_optics_callback)(void *user, enum pel_err err,
                                    const struct pel_fault *fault,
                                    const Pelagos__Optics *answer);
PEL_CHECK enum pel_err pel_frames_optics(struct pel_frames *frames,
                                         const Pelagos__OpticsQuery *question,
                                         pel_optics_callback done, void *user,
                                         struct pel_fault *fault);

/* A frame that is sealed: the same for all who show it. */
struct pel_sealed {
    const struct pel_snapshot *snapshot; /* NULL: the scene's present */
    double time_s;
    uint64_t number;
    int64_t present_ns;       /* CLOCK_MONOTONIC */
    uint64_t present_unix_ns; /* what all say of it; 0: each by its clock */
    uint32_t host_frame;
    double quality; /* scale of live views, where none is fixed here; 0: own */
    bool coasts;    /* the next one is late: pictures are stale by `exercise` */
};

/* From now on everything shows this and no more, instead of the scene as it is:
 * pictures, streams, queries of the surface. Live views draw one frame now, and
 * none by their own clock, until the scene's present is shown again. Takes a
 * reference. */
void pel_frames_show(struct pel_frames *frames, const struct pel_sealed *what);

/* Counters since the start, for /metrics and the log. */
struct pel_frames_stats {
    uint64_t frames_drawn, views_drawn, frames_skipped;
    uint64_t pictures_encoded, encoded_bytes, requests_refused;
    uint64_t large_drawn;      /* frames that were drawn in bands */
    uint64_t behind_drawn;     /* live pictures behind those of higher ranks */
    uint64_t losses;           /* of the device */
    uint64_t views_again;      /* drawn again for that */
    double loss_worst_ms;      /* until a renderer stood again */
    bool fallen_back;          /* to the software device */
    uint64_t pictures_dropped; /* whose clients had gone */
    uint64_t streams_left_out; /* of frames: too many pixels together */
    double live_megapixels;    /* of all live views */
    uint64_t surfaces, surfaces_prefetched; /* queries taken */
    /* Of these, processor time before and behind the threads that draw. */
    int64_t surfaces_urgent_ns, surfaces_behind_ns;
    double render_ms_median, render_ms_p95; /* of the last 256 views */
    double quality; /* scale of width and height of live views, 0.25..1 */
    double quality_wanted; /* that would hold their rate here */
    double quality_fixed;  /* by options; 0: none is */
    uint64_t quality_changes;
    double present_delay_ms; /* of live views, from the stamp */
    double encode_ms_median;
    uint64_t video_frames, video_bytes, video_keys; /* H.264 among them */
    double video_ms_median;
    unsigned subscriptions, requests_waiting;
    bool in_compute; /* the wrapper that shaded the last frame */
};
void pel_frames_get_stats(const struct pel_frames *frames,
                          struct pel_frames_stats *out);

/* Frames drawn a second between the last two calls that were a second or more
 * apart; 0 at first. */
double pel_frames_rate(struct pel_frames *frames);

/* Changes the cap of live views, 1..240 Hz, from the next frame on. */
void pel_frames_set_max_fps(struct pel_frames *frames, double max_fps);

/* Changes pel_frames_options.quality. */
void pel_frames_set_quality(struct pel_frames *frames, double quality);

/* Whether the renderer has returned nothing for more than 2 s with frames to
 * draw; on a software device for 4 us a pixel more, and not while it computes,
 * for two minutes and a minute of a core at most (programs are compiled). */
bool pel_frames_stuck(const struct pel_frames *frames);

/* Writes the counters as metrics `pelagos_frames_...`; user: the frames. */
void pel_frames_collect(void *user, struct pel_metrics_page *page);
