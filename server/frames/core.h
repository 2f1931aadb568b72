/* The control thread's side of the frame path. Everything here runs on the
 * control thread. */
#pragma once

#include <glib.h>

#include "bounds.h"
#include "frames/devices.h"
#include "frames/encoder_pool.h"
#include "frames/job.h"
#include "frames/mailbox.h"
#include "frames/prefetch.h"
#include "frames/present.h"
#include "frames/quality.h"
#include "frames/surface_pool.h"

#define PEL_JOBS_FIRST 8  /* with one device; */
#define PEL_JOBS_MORE 4   /* more for each other */
#define PEL_MAX_DRAWING 2 /* live jobs between start and pixels */
#define PEL_MAX_REQUESTS PEL_BOUND_PICTURES
#define PEL_MAX_STREAMS PEL_BOUND_LIVE_STREAMS
#define PEL_MAX_SUBSCRIPTIONS 256
#define PEL_MAX_SURFACE_QUERIES PEL_BOUND_SURFACE_QUERIES
#define PEL_MAX_OPTICS_QUERIES PEL_BOUND_OPTICS_QUERIES
#define PEL_MAX_SURFACE_POINTS PEL_BOUND_SURFACE_POINTS
#define PEL_MAX_SHOWN 64
#define PEL_MOMENTS 16

struct pel_frame_set; /* requests that are of one frame */

struct pel_frame_request {
    bool used;
    struct pel_frame_set *set; /* NULL: by itself */
    uint64_t id, order;
    char view[PEL_NAME_SIZE];
    uint32_t width, height; /* 0: the view's */
    bool has_time, float_samples;
    double time_s;
    Pelagos__FrameFormat format;
    int quality;
    unsigned layers;
    int64_t requested_ns;
    struct pel_output *output; /* NULL: waits for a frame */
    enum pel_rank rank;        /* of who asks */
    pel_frame_callback done;
    void *user;
};

struct pel_stream; /* (view, profile) */

/* How a stream is drawn: see lanes.c. */
enum pel_lane {
    PEL_LANE_FRONT,
    PEL_LANE_BESIDE, /* of a low rank, in the frames of the front */
    PEL_LANE_BEHIND, /* in a job of its own, in bands between the others */
};

enum pel_flow {
    PEL_FLOW_RUNS,
    PEL_FLOW_AWAITS_KEY,
    PEL_FLOW_PAUSED,
};

struct pel_subscription {
    struct pel_frames *frames;
    struct pel_stream *stream; /* NULL: its view is gone */
    enum pel_flow flow;
    bool dead; /* unsubscribed while callbacks run */
    struct pel_who who;
    pel_frame_callback on_frame;
    void *user;
    struct pel_subscription *next; /* of all subscriptions */
};

struct pel_stream {
    uint32_t serial; /* 0: not used */
    char view[PEL_NAME_SIZE];
    struct pel_profile profile;
    unsigned subscribers;
    unsigned paused;         /* of them */
    struct pel_track *track; /* of video */
    int64_t key_due_ns;      /* a key frame is wanted from then on; 0: none */
    int64_t key_ns;          /* when one was last wanted of the encoder */
    int64_t opened_ns;
    enum pel_lane lane; /* of the next frame */
    bool low;           /* its outputs are of low rank; while none is under way
                         * only this changes */
    uint64_t turn;      /* of the last frame behind that it was in */
};

/* How many streams of low ranks are drawn with those of high ranks. */
struct pel_lanes {
    bool high;       /* streams of high ranks run */
    bool split;      /* and others */
    unsigned beside; /* that many may be */
    int64_t calm_ns; /* since then frames kept their rate; 0: they did not */
    int64_t wait_ns; /* before there may be more */
    int64_t more_ns; /* when there were; 0: taken back */
};

/* What a frame shows, for questions about it. */
struct pel_shown {
    uint64_t number;
    const struct pel_snapshot *snapshot; /* NULL: none */
    double time_s;
};

/* What a frame shows is a function of these. */
struct pel_moment {
    uint64_t number; /* 0: none */
    uint64_t revision;
    unsigned stale;
    double time_s;
};

struct pel_frames {
    struct pel_scene *scene;
    struct pel_sealed sealed; /* what is shown of it; no snapshot: all */
    struct pel_mailbox box;
    struct pel_encoder_pool *pool;
    struct pel_surface_pool *surface_pool;
    struct pel_devices *devices;
    GSource *tick, *start, *watch;
    double max_fps;
    int64_t next_tick_ns;
    bool stopping;

    uint64_t number, job_order, last_id, last_order;
    struct pel_moment moments[PEL_MOMENTS]; /* the last ones */
    size_t next_moment;
    struct pel_quality quality;
    struct pel_lanes lanes;
    int64_t last_drawn_ns; /* when the last job's pictures were there */
    uint32_t last_serial;
    unsigned drawing;       /* jobs with render threads, but for large ones */
    unsigned drawing_live;  /* of them */
    unsigned drawing_large; /* with render threads, one a device at most */
    uint64_t live_pixels;   /* of the last live frame */
    uint64_t usual_pixels;  /* of the last job but large ones */
    int64_t usual_until_ns; /* after that it is history */
    bool last_was_live;
    struct pel_job *jobs;
    int job_count;
    struct pel_frame_request requests[PEL_MAX_REQUESTS];
    struct pel_stream streams[PEL_MAX_STREAMS];
    struct pel_subscription *subscriptions;
    unsigned subscription_count; /* with a stream */
    unsigned running_count;      /* of them not paused */
    const char *video_encoder;
    struct { /* for pel_frames_rate */
        uint64_t drawn;
        int64_t at_ns;
        double per_s;
    } rate;
    unsigned calling; /* depth of callbacks to subscribers */
    unsigned surface_count;
    struct pel_prefetch prefetch;
    struct pel_shown shown[PEL_MAX_SHOWN]; /* newest first */
    struct pel_surface_query *surfaces[PEL_MAX_SURFACE_QUERIES];
    unsigned optics_count;
    struct pel_optics_query *optics[PEL_MAX_OPTICS_QUERIES];

    uint64_t stuck_order; /* the last job that was logged as stuck */
    uint64_t slow_order;  /* likewise, as slow */
    struct pel_frames_stats stats;
    struct pel_window render_ms, encode_ms, video_ms;
    struct pel_present present;
};

/* --- shown.c: what there is to be seen ----------------------------------- */

/* Scale of the next live frame: that of a sealed one is the same on all nodes,
 * as long as none is fixed here. */
double pel_shown_scale(const struct pel_frames *frames);
/* Of the scene's present, or of what was sealed; a new reference, and time. */
const struct pel_snapshot *pel_shown_snapshot(const struct pel_frames *frames);
double pel_shown_time(const struct pel_frames *frames);

/* --- schedule.c: frames begin and end ------------------------------------ */

/* Timer of live views: draws one frame of every stream and waiting request. */
void pel_schedule_tick(void *user);
/* There is something else to be seen: draws it at once. */
void pel_schedule_shown(struct pel_frames *frames);
/* Starts frames for waiting requests, as far as there is room. */
void pel_schedule_start(void *user);
/* Has pel_schedule_start run in the next turn of the main loop. */
void pel_schedule_soon(struct pel_frames *frames);
/* Live views begin or end, or the rate changes. */
void pel_schedule_live(struct pel_frames *frames);
/* Timer that checks on frames being drawn; sets itself again. */
void pel_schedule_watch(void *user);
/* A job is drawn, or an output encoded. */
void pel_schedule_drawn(struct pel_frames *frames, struct pel_job *job);
void pel_schedule_output(struct pel_frames *frames, struct pel_output *output);
/* What a frame of this snapshot is drawn in. Left out is what takes long and so
 * is found where it is drawn: the sea, and lights but for the Sun's direction.
 */
struct pel_environment pel_environment_of(const struct pel_snapshot *s,
                                          double time_s);
/* Its lights and the night's sky. Any thread but the control thread: the Moon
 * and the planets take milliseconds after a leap in time. */
void pel_environment_light(const struct pel_snapshot *s,
                           struct pel_environment *env);
/* The same as seen from another place. */
struct pel_place;
void pel_environment_light_at(const struct pel_snapshot *s,
                              const struct pel_place *place,
                              struct pel_environment *env);

/* --- fair.c: bounds on what other clients wait for ----------------------- */

#define PEL_LONE_PIXELS (1u << 20) /* while there are no others */
uint64_t pel_fair_job_pixels(const struct pel_job *job);
/* Remembers the size of a job that is about to be drawn whole. */
void pel_fair_note(struct pel_frames *frames, const struct pel_job *job);
/* Pixels of a band, such that no client waits for it longer than for a frame of
 * its own. */
uint64_t pel_fair_band(const struct pel_frames *frames);
/* Whether a request, with its set, has to be drawn in bands. */
bool pel_fair_is_large(const struct pel_frames *frames,
                       const struct pel_frame_request *request);
/* Whether the job draws this view in this size anyway. */
bool pel_fair_has_draw(const struct pel_job *job,
                       const struct pel_frame_request *request);
/* Whether the job may take the request along. */
bool pel_fair_join(const struct pel_frames *frames, const struct pel_job *job,
                   const struct pel_frame_request *request);

/* --- requests.c ---------------------------------------------------------- */

/* Pixels of a request, in the views as they are now. */
uint64_t pel_request_pixels(const struct pel_snapshot *s,
                            const struct pel_frame_request *request);
/* Bytes of a picture before it is encoded; 0: there is no such view. */
size_t pel_request_bytes(const struct pel_snapshot *s,
                         const Pelagos__FrameRequest *request);
/* Whether a request may be made as it is; counts a refusal. */
PEL_CHECK enum pel_err pel_request_check(struct pel_frames *frames,
                                         const Pelagos__FrameRequest *request,
                                         struct pel_fault *fault);
/* Refuses with a path and words of its own; returns code. */
enum pel_err pel_request_refuse(struct pel_frames *frames,
                                struct pel_fault *fault, enum pel_err code,
                                const char *path, const char *message);
/* Queues a checked request for a frame; NULL: all places are taken. */
struct pel_frame_request *pel_request_take(struct pel_frames *frames,
                                           const Pelagos__FrameRequest *request,
                                           pel_frame_callback done, void *user);
/* Layers that it reads back, of enum pel_layer. */
unsigned pel_request_layers(const Pelagos__FrameRequest *request);
/* Its callback is not called any more. */
void pel_request_forget(struct pel_frames *frames, uint64_t id);
unsigned pel_requests_free(const struct pel_frames *frames);
/* Answers and forgets it; frame NULL with an error. */
void pel_request_finish(struct pel_frames *frames,
                        struct pel_frame_request *request, enum pel_err err,
                        const struct pel_fault *fault, struct pel_frame *frame);
void pel_requests_finish_all(struct pel_frames *frames);

/* --- frameset.c ---------------------------------------------------------- */

/* How many requests a set has, all of them waiting. */
size_t pel_set_count(const struct pel_frame_set *set);
/* Whether one of its requests is in a job already. */
bool pel_set_begun(const struct pel_frame_set *set);
void pel_set_begin(struct pel_frame_set *set);

#define PEL_LIVE_PIXELS                                                        \
    ((uint64_t)PEL_BOUND_LIVE_PIXELS) /* of all streams together */

/* --- live.c -------------------------------------------------------------- */

/* Pixels of a live view in a profile; 0: there is no such view. */
uint64_t pel_live_pixels(const struct pel_snapshot *s, const char *view,
                         const struct pel_profile *profile);
/* Ends the streams whose view is not in the snapshot; NULL: all. */
void pel_live_check(struct pel_frames *frames, const struct pel_snapshot *s);
/* What the stream adds to a job that begins now: false nothing, as nobody can
 * use it or its encoder is behind. */
bool pel_live_output(struct pel_frames *frames, struct pel_stream *stream,
                     struct pel_output *want);
/* Records that it did; `key`: with a key frame. */
void pel_live_began(struct pel_stream *stream, bool key);
/* Gives a frame to the subscribers of stream `serial`; why: of the error. */
void pel_live_deliver(struct pel_frames *frames, uint32_t serial,
                      enum pel_err err, const char *why,
                      struct pel_frame *frame);
void pel_live_finish(struct pel_frames *frames);
/* Of each stream the highest of those who watch it. */
void pel_live_owners(const struct pel_frames *frames,
                     struct pel_who owners[PEL_MAX_STREAMS]);
/* Pictures of a stream that are not delivered yet. */
unsigned pel_live_under_way(const struct pel_frames *frames, uint32_t serial);

/* --- lanes.c ------------------------------------------------------------- */

void pel_lanes_begin(struct pel_lanes *lanes);
/* Gives every stream its lane in the next frame. */
void pel_lanes_sort(struct pel_frames *frames);
/* Whether so many pictures of low ranks wait to be encoded that no more are
 * begun. */
bool pel_lanes_full(const struct pel_frames *frames);
/* The stream behind whose turn it is; NULL: none is left for frame `turn`. */
struct pel_stream *pel_lanes_next(struct pel_frames *frames, uint64_t turn);
/* A live frame kept the renderer for so long. */
void pel_lanes_feed(struct pel_lanes *lanes, double busy_ms, double period_ms,
                    int64_t now_ns);

/* --- surface.c ----------------------------------------------------------- */
/* Remembers what a job shows that begins now. */
void pel_surface_keep(struct pel_frames *frames, const struct pel_job *job);
void pel_surface_answer(struct pel_frames *frames,
                        struct pel_surface_query *query);
void pel_surface_finish_all(struct pel_frames *frames);

/* --- optics_water.c ------------------------------------------------------ */
void pel_optics_read_water(const Pelagos__WaterQuery *from,
                           struct pel_water_question *to);
/* INVALID: wavelengths that the source has no answer for. */
PEL_CHECK enum pel_err pel_optics_check_water(const Pelagos__OpticsQuery *query,
                                              struct pel_fault *fault);
Pelagos__WaterLight *pel_optics_water_message(const struct pel_optics_query *q);

/* --- optics.c ------------------------------------------------------------ */
void pel_optics_answer(struct pel_frames *frames,
                       struct pel_optics_query *query);
/* joined: the threads have ended. */
void pel_optics_finish_all(struct pel_frames *frames, bool joined);
