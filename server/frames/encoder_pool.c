#include "frames/encoder_pool.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/lock.h"
#include "base/log.h"
#include "frames/picture_notes.h"
#include "frames/pictureplanes.h"
#include "frames/radarview.h"
#include "proto/formats.h"

#define STOP_NS 1000000000LL
#define BEHIND_LEAST 2   /* threads for low ranks, */
#define FRONT_A_BEHIND 4 /* and one for so many others */
#define BEHIND_NICE 10   /* those that draw have 5 */
#define MOST_THREADS (PEL_MAX_ENCODERS * (FRONT_A_BEHIND + 1) / FRONT_A_BEHIND)

/* Pictures of low ranks have threads of their own. */
enum { LANE_FRONT, LANE_BEHIND, LANES };

struct lane {
    struct pel_queue fast, slow;
    struct encoder *idle; /* the last one first */
    int threads;
    int slow_busy; /* of them: one is left to what is fast */
};

struct encoder {
    struct pel_encoder_pool *pool;
    pthread_t thread;
    struct encoder *next; /* of the idle; the pool's lock protects it */
    bool slow;            /* its work is; the pool's lock protects it */
    struct lane *lane;    /* whose work it does, and nothing else */
    pthread_mutex_t lock; /* protects what follows; after the pool's */
    pthread_cond_t wake;
    struct pel_mail *handed;    /* its next work; NULL: it waits */
    struct pel_output *at_work; /* NULL: none */
};

/* Work is handed to the encoder that was busy last, whose memory is still in a
 * cache, and nobody else wakes up; it comes back to the pool's lock when it has
 * done it. */
struct pel_encoder_pool {
    pthread_mutex_t lock; /* protects what follows, down to ended */
    pthread_cond_t over;
    struct lane lanes[LANES];
    int count, ended;
    struct encoder encoders[MOST_THREADS];
    atomic_bool stop;
    struct pel_mailbox *box;
    void (*released)(void *user, const struct pel_job_draw *part);
    void *user;
};

static void fill_frame(struct pel_frame *frame, const struct pel_output *output)
{
    const struct pel_job *job = output->job;
    const struct pel_job_draw *part = &job->parts[output->draw];
    const struct pel_picture *picture = part->picture;
    snprintf(frame->view, sizeof frame->view, "%s",
             job->snapshot->views[part->view].name);
    frame->number = output->stream ? job->number : job->moment;
    frame->revision = job->snapshot->revision;
    frame->host_frame = job->host_frame;
    frame->stale =
        pel_snapshot_stale(job->snapshot, job->environment.time_s) | job->stale;
    frame->in_ground = pel_camera_in_ground(job, output->draw);
    frame->time_s = job->environment.time_s;
    frame->exposure_ev = picture->exposure_ev;
    frame->width = part->width;
    frame->height = part->height;
    frame->drawn_width = picture->width;
    frame->drawn_height = picture->height;
    frame->codec = output->track ? output->track->codec : PEL_CODEC_PICTURE;
    frame->format = output->format;
    frame->requested_ns = job->requested_ns;
    frame->present_ns = job->present_ns;
    frame->present_unix_ns = job->present_unix_ns;
    frame->drawn_ns = picture->drawn_ns;
    frame->device = part->device;
    frame->render_ms = part->radar ? picture->render_ms : part->render_ms;
}

static enum pel_err encode_video(struct pel_output *output,
                                 struct pel_frame *frame,
                                 struct pel_bytes *bytes)
{
    const struct pel_job *job = output->job;
    const struct pel_job_draw *part = &job->parts[output->draw];
    const struct pel_picture *p = part->picture;
    bool scaled = p->width != part->width || p->height != part->height;
    struct pel_fault fault = { 0 };
    struct pel_planes_given planes;
    struct pel_video_picture picture = {
        .rgba = p->rgba,
        .planes = pel_picture_planes(p, &planes) ? &planes : NULL,
        .width = p->width,
        .height = p->height,
        .out_width = scaled ? part->width : 0,
        .out_height = scaled ? part->height : 0,
        .stamp_ns = job->requested_ns,
        .key = output->want_key,
    };
    enum pel_err err =
        pel_video_encode(output->track->video, &picture, output->kbps, bytes,
                         &frame->key, &fault);
    if (err != PEL_OK) {
        snprintf(output->why, sizeof output->why, "%.159s", fault.message);
    }
    frame->width &= ~1u; /* as it leaves the encoder */
    frame->height &= ~1u;
    return err;
}

static pel_encode *const encoders[PEL_FORMATS] = {
#define PEL_FORMAT(ID, ending, mime, encoder, uses, text)                      \
    pel_##encoder##_encode,
#include "proto/formats.def"
};

static enum pel_err encode_bytes(const struct pel_output *output,
                                 struct pel_bytes *bytes)
{
    const struct pel_job_draw *part = &output->job->parts[output->draw];
    const struct pel_picture *p = part->picture;
    const struct pel_format *format = pel_format_of(output->format);
    pel_encode *encode = encoders[format - pel_format_table];
    if (part->radar && format->uses & (PEL_FORMAT_LAYERS | PEL_FORMAT_TRUTH)) {
        return PEL_ERR_INVALID; /* it became one since it was asked for */
    }
    if (format->uses & PEL_FORMAT_LAYERS) {
        return pel_picture_encode_layers(output, part->device_name, encode,
                                         bytes);
    }
    if (format->uses & PEL_FORMAT_TRUTH) {
        return pel_picture_encode_truth(output, encode, bytes);
    }
    /* Files that are kept say of their camera; live streams do not. */
    struct pel_photo photo;
    struct pel_photo_blocks blocks;
    if (!output->stream) {
        pel_picture_photo(output, &photo);
        pel_photo_write(&photo, &blocks);
    }
    struct pel_planes_given planes;
    const struct pel_encode_input input = {
        .planes = pel_picture_planes(p, &planes) ? &planes : NULL,
        .scan = pel_picture_scan(p),
        .width = p->width,
        .height = p->height,
        .cancel = &output->cancel,
        .photo = output->stream ? NULL : &blocks,
        .rgba = p->rgba,
        .out_width = part->width,
        .out_height = part->height,
        .quality = output->quality,
    };
    return encode(&input, bytes);
}

/* Before it is posted, since it may be gone then. */
static void leave_work(struct encoder *encoder)
{
    pthread_mutex_lock(&encoder->lock);
    encoder->at_work = NULL;
    pthread_mutex_unlock(&encoder->lock);
}

static void encode_output(struct encoder *encoder, struct pel_output *output)
{
    struct pel_encoder_pool *pool = encoder->pool;
    struct pel_job_draw *part = &output->job->parts[output->draw];
    output->err = part->err == PEL_OK && atomic_load(&output->cancel)
                      ? PEL_ERR_CONFLICT
                      : part->err;
    snprintf(output->why, sizeof output->why, "%s",
             part->err == PEL_ERR_GPU
                 ? "the graphics device failed while it was drawn; see the log"
                 : "");
    output->frame = NULL;
    if (output->err == PEL_OK && part->radar) {
        output->err = pel_radar_view_draw(part, &output->cancel);
    }
    if (output->err == PEL_OK) {
        int64_t start = pel_now_ns();
        struct pel_bytes bytes = { 0 };
        struct pel_frame *frame = pel_frame_create();
        output->err = PEL_ERR_NO_MEMORY;
        if (frame) {
            fill_frame(frame, output);
            frame->key = !output->track;
            output->err = output->track ? encode_video(output, frame, &bytes)
                                        : encode_bytes(output, &bytes);
        }
        if (output->err == PEL_OK) {
            frame->encoded_ns = pel_now_ns();
            frame->encode_ms = (double)(frame->encoded_ns - start) * 1e-6;
            pel_frame_set_bytes(frame, &bytes);
            output->frame = frame;
        } else {
            pel_frame_unref(frame);
        }
    }
    output->track = NULL; /* its reference is the caller's now */
    if (atomic_fetch_sub(&part->users, 1) == 1 && part->picture) {
        if (part->radar) {
            pel_radar_view_release(part);
        } else {
            pel_picture_release(part->picture);
            part->picture = NULL;
        }
        pool->released(pool->user, part);
    }
    leave_work(encoder);
    pel_mailbox_post(pool->box, &output->mail);
}

/* The encoder that this work is for, NULL: any thread may do it beside. */
static struct pel_track *track_of(struct pel_mail *mail)
{
    return mail->kind == PEL_MAIL_TRACK    ? (struct pel_track *)mail
           : mail->kind == PEL_MAIL_OUTPUT ? ((struct pel_output *)mail)->track
                                           : NULL;
}

/* First of the queue whose encoder is free: a stream keeps its order, and
 * waits for nobody else's. */
static struct pel_mail *pop_free(struct pel_queue *queue)
{
    struct pel_mail *before = NULL;
    for (struct pel_mail *mail = queue->first; mail; mail = mail->next) {
        struct pel_track *track = track_of(mail);
        if (track && track->busy) {
            before = mail;
            continue;
        }
        if (before) {
            before->next = mail->next;
        } else {
            queue->first = mail->next;
        }
        if (queue->last == mail) {
            queue->last = before;
        }
        if (track) {
            track->busy = true;
        }
        mail->next = NULL;
        return mail;
    }
    return NULL;
}

/* Next work under the lock; *slow tells which kind it is. */
static struct pel_mail *take(struct lane *lane, bool *slow)
{
    int slow_limit = lane->threads > 1 ? lane->threads - 1 : 1;
    struct pel_mail *mail = pop_free(&lane->fast);
    *slow = false;
    if (!mail && lane->slow_busy < slow_limit) {
        mail = pel_queue_pop(&lane->slow);
        *slow = mail != NULL;
        lane->slow_busy += *slow;
    }
    return mail;
}

static void set_work(struct encoder *encoder, struct pel_mail *mail)
{
    pthread_mutex_lock(&encoder->lock);
    encoder->handed = mail;
    encoder->at_work =
        mail->kind == PEL_MAIL_OUTPUT ? (struct pel_output *)mail : NULL;
    pthread_mutex_unlock(&encoder->lock);
}

/* To be woken when the pool's lock is let go. */
struct woken {
    int count;
    struct encoder *encoder[MOST_THREADS];
};

/* Under the pool's lock: gives the idle what there is to do. */
static void assign(struct pel_encoder_pool *pool, struct woken *woken)
{
    woken->count = 0;
    for (int i = 0; i < LANES && !atomic_load(&pool->stop); i++) {
        struct lane *lane = &pool->lanes[i];
        struct pel_mail *mail;
        while (lane->idle && (mail = take(lane, &lane->idle->slow))) {
            struct encoder *encoder = lane->idle;
            lane->idle = encoder->next;
            woken->encoder[woken->count++] = encoder;
            set_work(encoder, mail);
        }
    }
}

static void wake(const struct woken *woken)
{
    for (int i = 0; i < woken->count; i++) {
        pthread_cond_signal(&woken->encoder[i]->wake);
    }
}

/* NULL: all ends. */
static struct pel_mail *wait_handed(struct encoder *encoder)
{
    pthread_mutex_lock(&encoder->lock);
    while (!encoder->handed && !atomic_load(&encoder->pool->stop)) {
        pthread_cond_wait(&encoder->wake, &encoder->lock);
    }
    struct pel_mail *mail = encoder->handed;
    encoder->handed = NULL;
    pthread_mutex_unlock(&encoder->lock);
    return mail;
}

/* After work for `track` (NULL: for none), whose encoder is free for its next
 * picture now. Each mail that names a track holds a reference to it. */
static struct pel_mail *next_work(struct encoder *encoder,
                                  struct pel_track *track)
{
    struct pel_encoder_pool *pool = encoder->pool;
    struct woken woken;
    pthread_mutex_lock(&pool->lock);
    if (track) {
        track->busy = false;
    }
    encoder->lane->slow_busy -= encoder->slow;
    encoder->slow = false;
    if (!atomic_load(&pool->stop)) {
        encoder->next = encoder->lane->idle;
        encoder->lane->idle = encoder;
    }
    assign(pool, &woken);
    pthread_mutex_unlock(&pool->lock);
    wake(&woken);
    pel_track_unref(track);
    return wait_handed(encoder);
}

static void end(struct pel_encoder_pool *pool)
{
    pthread_mutex_lock(&pool->lock);
    pool->ended++;
    pthread_cond_broadcast(&pool->over);
    pthread_mutex_unlock(&pool->lock);
}

static void *run(void *argument)
{
    struct encoder *encoder = argument;
    struct pel_encoder_pool *pool = encoder->pool;
    struct pel_mail *mail;
    struct pel_track *track = NULL;
    if (encoder->lane == &encoder->pool->lanes[LANE_BEHIND]) {
        (void)setpriority(PRIO_PROCESS, (id_t)gettid(), BEHIND_NICE);
    }
    while ((mail = next_work(encoder, track))) {
        track = track_of(mail);
        if (mail->kind == PEL_MAIL_OUTPUT) {
            encode_output(encoder, (struct pel_output *)mail);
        } else if (mail->kind == PEL_MAIL_OPTICS) {
            pel_optics_reference((struct pel_optics_query *)mail);
            pel_mailbox_post(pool->box, mail);
        }
    }
    end(pool);
    return NULL;
}

enum pel_err pel_encoder_pool_create(
    int threads, struct pel_mailbox *box,
    void (*released)(void *user, const struct pel_job_draw *part), void *user,
    struct pel_encoder_pool **out)
{
    struct pel_encoder_pool *pool = calloc(1, sizeof *pool);
    if (!pool) {
        return PEL_ERR_NO_MEMORY;
    }
    pool->box = box;
    pool->released = released;
    pool->user = user;
    pel_lock_init(&pool->lock);
    pel_cond_init(&pool->over);
    threads = threads > PEL_MAX_ENCODERS ? PEL_MAX_ENCODERS : threads;
    int behind = threads / FRONT_A_BEHIND;
    behind = behind > BEHIND_LEAST ? behind : BEHIND_LEAST;
    pthread_mutex_lock(&pool->lock);
    for (int i = 0; i < threads + behind; i++) {
        struct encoder *encoder = &pool->encoders[i];
        encoder->pool = pool;
        encoder->lane = &pool->lanes[i < threads ? LANE_FRONT : LANE_BEHIND];
        pel_lock_init(&encoder->lock);
        pthread_cond_init(&encoder->wake, NULL);
        if (pthread_create(&encoder->thread, NULL, run, encoder) != 0) {
            break;
        }
        pthread_setname_np(encoder->thread, "encode");
        encoder->lane->threads++;
        pool->count = i + 1;
    }
    pthread_mutex_unlock(&pool->lock);
    if (pool->count == 0) {
        if (pel_encoder_pool_stop(pool)) {
            pel_encoder_pool_destroy(pool);
        }
        return PEL_ERR_IO;
    }
    *out = pool;
    return PEL_OK;
}

bool pel_encoder_pool_stop(struct pel_encoder_pool *pool)
{
    pthread_mutex_lock(&pool->lock);
    atomic_store(&pool->stop, true);
    for (int i = 0; i < pool->count; i++) {
        struct encoder *encoder = &pool->encoders[i];
        pthread_mutex_lock(&encoder->lock);
        if (encoder->at_work) {
            atomic_store(&encoder->at_work->cancel, true);
        }
        pthread_cond_signal(&encoder->wake);
        pthread_mutex_unlock(&encoder->lock);
    }
    bool ended = pel_cond_wait_ended(&pool->over, &pool->lock, &pool->ended,
                                     pool->count, STOP_NS);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < pool->count; i++) {
        if (ended) {
            pthread_join(pool->encoders[i].thread, NULL);
        } else {
            pthread_detach(pool->encoders[i].thread);
        }
    }
    return ended;
}

void pel_encoder_pool_destroy(struct pel_encoder_pool *pool)
{
    if (pool) {
        struct pel_mail *mail;
        while ((mail = pel_queue_pop(&pool->lanes[LANE_FRONT].fast)) ||
               (mail = pel_queue_pop(&pool->lanes[LANE_BEHIND].fast))) {
            if (mail->kind == PEL_MAIL_TRACK) {
                pel_track_unref((struct pel_track *)mail);
            }
        }
        for (int i = 0; i < pool->count; i++) {
            pthread_mutex_destroy(&pool->encoders[i].lock);
            pthread_cond_destroy(&pool->encoders[i].wake);
        }
        pthread_cond_destroy(&pool->over);
        pthread_mutex_destroy(&pool->lock);
        free(pool);
    }
}

static void push(struct pel_encoder_pool *pool, struct pel_queue *queue,
                 struct pel_mail *mail)
{
    struct woken woken;
    pthread_mutex_lock(&pool->lock);
    pel_queue_push(queue, mail);
    assign(pool, &woken);
    pthread_mutex_unlock(&pool->lock);
    wake(&woken);
}

/* Where threads were short there is none behind. */
static struct lane *lane_of(struct pel_encoder_pool *pool, bool low)
{
    struct lane *behind = &pool->lanes[LANE_BEHIND];
    return low && behind->threads > 0 ? behind : &pool->lanes[LANE_FRONT];
}

void pel_encoder_pool_push_output(struct pel_encoder_pool *pool,
                                  struct pel_output *output)
{
    output->mail.kind = PEL_MAIL_OUTPUT;
    struct lane *lane = lane_of(pool, output->low);
    bool quick = pel_format_of(output->format)->uses & PEL_FORMAT_QUICK;
    bool radar = output->job->parts[output->draw].radar;
    bool large = output->job->large && !output->job->live;
    bool fast = output->track || (quick && !large && !radar);
    push(pool, fast ? &lane->fast : &lane->slow, &output->mail);
}

void pel_encoder_pool_push_track(struct pel_encoder_pool *pool,
                                 struct pel_track *track, bool low)
{
    track->mail.kind = PEL_MAIL_TRACK;
    push(pool, &lane_of(pool, low)->fast, &track->mail);
}

const atomic_bool *pel_encoder_pool_cancel(const struct pel_encoder_pool *pool)
{
    return &pool->stop;
}

void pel_encoder_pool_push_optics(struct pel_encoder_pool *pool,
                                  struct pel_optics_query *query)
{
    push(pool, &pool->lanes[LANE_FRONT].slow, &query->mail);
}
