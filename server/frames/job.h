/* What travels between the control, render and encoder threads: jobs (the
 * draws of one moment), their outputs (one encoded picture each) and surface
 * queries. Each is owned by one thread at a time and handed on through a
 * locked queue; what several read is written before it is handed on. */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "base/err.h"
#include "encode/encode.h"
#include "encode/video.h"
#include "frames/frames.h"
#include "optics/waterreport.h"
#include "render/probe.h"
#include "render/renderer.h"
#include "render/waterprobe.h"
#include "scene/place.h"

#define PEL_MAX_OUTPUTS 192 /* 64 streams and 128 requests */
#define PEL_MAX_DEVICES 16

enum pel_mail_kind {
    PEL_MAIL_JOB_DRAWN, /* every picture is with the encoders, or failed */
    PEL_MAIL_OUTPUT,    /* encoded, or failed */
    PEL_MAIL_SURFACE,
    PEL_MAIL_OPTICS,
    PEL_MAIL_TRACK, /* to the encoders only: this stream is over */
};

/* Link of every queue; the first member of what it links. */
struct pel_mail {
    struct pel_mail *next;
    enum pel_mail_kind kind;
};

struct pel_job;

/* An encoder of a stream's video: its pictures go through it in order, one at a
 * time. References: the stream's and each output's. */
struct pel_track {
    struct pel_mail mail; /* of its end */
    atomic_int references;
    bool busy; /* with an encoder thread; the pool's lock protects it */
    enum pel_codec codec;
    struct pel_video *video;
};
/* NULL: no memory. */
struct pel_track *pel_track_create(const struct pel_video_config *config);
struct pel_track *pel_track_ref(struct pel_track *track);
void pel_track_unref(struct pel_track *track); /* NULL allowed; may wait some
                                                * ms for GStreamer's threads */

struct pel_output {
    struct pel_mail mail;
    struct pel_job *job;
    size_t draw; /* index into job->draws */
    Pelagos__FrameFormat format;
    int quality;
    bool float_samples;
    unsigned layers;         /* of enum pel_layer */
    uint32_t stream;         /* serial of the live stream it feeds, 0: none */
    struct pel_track *track; /* H.264 by this one, else NULL */
    unsigned kbps;
    bool want_key;
    bool low;           /* encoded behind the others: of a low rank */
    atomic_bool cancel; /* no client waits for it any more */
    bool done;          /* control thread */
    bool delivered;     /* control thread */
    enum pel_err err;
    char why[160];           /* of an error, or "" */
    struct pel_frame *frame; /* NULL on error */
};

/* What one device draws of a job: the draws of its job that name it. */
struct pel_share {
    struct pel_mail mail; /* to its render thread */
    struct pel_job *job;
    size_t count;
    uint8_t draws[PEL_MAX_VIEWS]; /* of the job, in order */
    size_t left; /* not yet collected, nor with another; render thread */
};

/* The render thread's and the encoders' side of one draw. */
struct pel_job_draw {
    struct pel_job *job;
    struct pel_share *share;   /* NULL: of a large job, or passed on */
    struct pel_job_draw *next; /* of what is drawn again */
    size_t view;               /* index in the snapshot */
    uint32_t width, height;    /* asked for; what is drawn may be coarser */
    bool live;                 /* a stream's, perhaps a request's too */
    bool coarse;               /* of it: drawn at the job's scale */
    bool radar;                /* made by an encoder (frames/radarview.h) */
    size_t place;              /* of the job's places; 0: the origin's */
    size_t bytes;              /* of its readback buffer */
    enum pel_err err;
    struct pel_picture *picture;
    unsigned device;         /* that drew it: of pel_devices */
    const char *device_name; /* its; lives as long as the devices */
    atomic_int users;        /* outputs that still read the picture */
    uint32_t rows_begun;     /* in bands; render thread */
    unsigned losses;      /* of the device while it was drawn; render thread */
    int64_t submitted_ns; /* when its commands were all given */
    double submit_ms;     /* its share of giving them */
    double render_ms;
};

/* Where views stand that have a light of their own. */
struct pel_job_place {
    struct pel_place place;
    struct pel_environment environment; /* the job's, but for that */
    struct pel_job_things *things;      /* of a far place; NULL: the job's */
};

struct pel_job {
    struct pel_mail mail;
    bool used, live, drawn; /* control thread */
    bool large;             /* drawn in bands, between the other jobs */
    uint64_t order;         /* of beginning, never twice */
    uint64_t number;        /* of live pictures: see pel_frame */
    uint64_t moment; /* of others: the first frame that showed the same */
    uint32_t host_frame;
    int64_t requested_ns;
    int64_t present_ns;
    uint64_t present_unix_ns; /* 0: it is not sealed */
    unsigned stale;           /* beyond the snapshot's, of enum pel_stale */
    double scale;             /* of live draws */
    int64_t launched_ns;
    int64_t drawn_ns; /* when the last picture was there */
    const struct pel_snapshot *snapshot;
    struct pel_environment environment;
    struct pel_object objects[PEL_MAX_ENTITIES]; /* its */
    struct pel_lamp lamps[PEL_MAX_LAMPS];        /* its */
    size_t place_count; /* with the origin's, which has no row */
    struct pel_job_place places[PEL_MAX_VIEWS];
    uint64_t asked_pixels; /* of requests, that are not drawn anyway */
    size_t draw_count;
    struct pel_draw draws[PEL_MAX_VIEWS]; /* user: &parts[i] */
    struct pel_job_draw parts[PEL_MAX_VIEWS];
    size_t output_count;
    struct pel_output outputs[PEL_MAX_OUTPUTS];
    struct pel_share shares[PEL_MAX_DEVICES]; /* of draws that are not large */
    size_t begun; /* draws of a large job; render thread */
    atomic_size_t collected;
    pthread_mutex_t standing; /* protects stood, and what pel_job_stand fills */
    bool stood;
    struct pel_fault fault; /* of the drawing, when it failed */
};

/* Fills in what the control thread does not wait for: the sea, ship waves and
 * what is afloat in them, cameras too; once, by the first render thread that
 * draws of it. */
void pel_job_stand(struct pel_job *job);
/* What a draw shows: of its place, when the job stands. */
const struct pel_environment *pel_job_environment(const struct pel_job *job,
                                                  size_t draw);
/* Local heading less true heading at a draw's camera [rad]; at the origin's
 * place 0. */
double pel_job_turned(const struct pel_job *job, size_t draw);
/* Finds the place of a draw's camera, or adds it. */
void pel_job_settle_place(struct pel_job *job, size_t draw);
/* Gives back what that holds; when all is collected, or no thread draws. */
void pel_job_settle(struct pel_job *job);
/* Gives back the rest, which encoders read. */
void pel_job_end(struct pel_job *job);

struct pel_surface_text {
    char *text;
    size_t size;
};

struct pel_surface_query {
    struct pel_mail mail;
    const struct pel_snapshot *snapshot;
    double time_s;
    bool moving;                            /* accelerations too */
    bool foam;                              /* its share too */
    enum pel_rank rank;                     /* of who asks */
    size_t count, begun, answered, written; /* the last three: the pool's */
    struct pel_vec2 *points;
    struct pel_surface_sample *samples;
    struct pel_surface_form form;   /* slice NULL: none */
    struct pel_surface_text *parts; /* of its slices */
    char *text;                     /* of all, malloc()ed */
    size_t size;
    pel_surface_callback done;
    void *user;
};

/* The question for light in the water, and its answer by wavelength. */
struct pel_water_question {
    struct pel_geometry at;
    bool montecarlo;
    unsigned paths, seed;
    int count; /* wavelengths of the reference; 0: the three */
    double first_nm, step_nm;
    struct pel_water_report *reports; /* the reference's answer, [count or 3] */
    struct pel_water_parts light;     /* the others' */
    double total[PEL_WATER_WAVELENGTHS], error[PEL_WATER_WAVELENGTHS];
    double bottom_direct[PEL_WATER_WAVELENGTHS];
};

/* To the encoder threads for the reference's answer, to the render thread for
 * the device's. */
struct pel_optics_query {
    struct pel_mail mail;
    const struct pel_snapshot *snapshot;
    Pelagos__OpticsQuery *asked;        /* without its patch */
    double time_s;                      /* that it is about */
    struct pel_environment environment; /* this and what follows: settled */
    Pelagos__OpticsQuery__QuestionCase question;
    bool gpu;
    struct pel_probe probe;
    struct pel_probe_answer answer;
    struct pel_rgb night; /* of the sky's radiance, the night's own */
    struct pel_water_question water;
    enum pel_err err;
    struct pel_fault fault;
    Pelagos__Optics *made; /* the answer, concluded; NULL: a fault */
    pel_optics_callback done;
    void *user;
};
/* Answers what is in the water by the reference or the Monte Carlo. */
PEL_CHECK enum pel_err pel_optics_water(struct pel_optics_query *query);
/* Answers from the reference; any thread. */
void pel_optics_reference(struct pel_optics_query *query);

/* What the query is about, on the thread that answers it: the Sun, Moon and
 * night of its moment take milliseconds. Slopes that it leaves open are taken
 * from the sea, which is built where it is not built yet. */
void pel_optics_settle(struct pel_optics_query *query);

/* Adds what the night's sky has to an answer that lacks it, some 10 ms, and
 * makes the message. */
void pel_optics_conclude(struct pel_optics_query *query);

/* A picture of `view` with room for what the encoder gives; NULL: no memory. */
struct pel_frame *pel_frame_create(void);
/* Takes the bytes. */
void pel_frame_set_bytes(struct pel_frame *frame, struct pel_bytes *bytes);

/* Has draw `output->draw` of the job encoded by layers, with attributes that
 * are a function of what is drawn. Any thread. */
PEL_CHECK enum pel_err
pel_picture_encode_layers(const struct pel_output *output, const char *device,
                          pel_encode *encode, struct pel_bytes *out);

/* The same of what the draw shows of entities, as JSON of a FrameTruth. */
PEL_CHECK enum pel_err pel_picture_encode_truth(const struct pel_output *output,
                                                pel_encode *encode,
                                                struct pel_bytes *out);
