#include "frames/renderloop.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/lock.h"
#include "base/log.h"
#include "frames/loss.h"
#include "frames/renderloop_parts.h"
#include "scene/lamps.h"
#include "scene/washes.h"

/* Readback memory in flight or with the encoders, of large jobs and of the
 * others; one picture always fits. */
#define READBACK_BUDGET ((size_t)256 << 20)
#define MAX_SUBMITTED 2
#define MAX_REFUSALS 100 /* 2 ms apart */
#define STOP_NS 2000000000LL

void pel_renderloop_progress(struct pel_renderloop *loop)
{
    atomic_store(&loop->progress_ns, pel_now_ns());
}

/* --- one picture is there ------------------------------------------------ */

/* Its outputs go to the encoders; after the last picture the job goes back. */
static void finish_part(struct pel_renderloop *loop, struct pel_job_draw *part)
{
    struct pel_job *job = part->job;
    size_t draw = (size_t)(part - job->parts);
    bool last = ++job->collected == job->draw_count;
    for (size_t i = 0; i < job->output_count; i++) {
        if (job->outputs[i].draw == draw) {
            pel_encoder_pool_push_output(loop->pool, &job->outputs[i]);
        }
    }
    pel_renderloop_progress(loop);
    if (last) {
        job->drawn_ns = pel_now_ns();
        loop->submitted -= !job->large;
        job->mail.kind = PEL_MAIL_JOB_DRAWN;
        pel_mailbox_post(loop->box, &job->mail);
    }
}

/* How long this picture kept the device: its share of giving the commands
 * (software renderers draw meanwhile), then the time since they were given or
 * the picture before it was there. */
static double busy_ms(struct pel_renderloop *loop,
                      const struct pel_job_draw *part,
                      const struct pel_picture *picture)
{
    int64_t since = part->submitted_ns > loop->drawn_ns ? part->submitted_ns
                                                        : loop->drawn_ns;
    int64_t wait_ns = picture->drawn_ns - since;
    loop->drawn_ns = picture->drawn_ns;
    return part->submit_ms + (wait_ns > 0 ? (double)wait_ns * 1e-6 : 0);
}

void pel_renderloop_fail(struct pel_renderloop *loop, struct pel_job *job,
                         size_t first, size_t count, enum pel_err err)
{
    size_t bytes = 0;
    for (size_t i = first; i < first + count; i++) {
        bytes += job->parts[i].bytes;
        job->parts[i].err = err;
    }
    atomic_fetch_sub(&loop->held_bytes, bytes);
    for (size_t i = first; i < first + count; i++) {
        finish_part(loop, &job->parts[i]);
    }
}

static size_t in_flight(const struct pel_renderloop *loop)
{
    return loop->renderer ? pel_renderer_in_flight(loop->renderer) : 0;
}

/* --- one picture is collected --------------------------------------------- */

static bool collect_one(struct pel_renderloop *loop, int64_t wait_ns)
{
    if (pel_loss_noticed(loop)) {
        return false;
    }
    struct pel_picture *picture = pel_renderer_collect(loop->renderer, wait_ns);
    if (!picture) {
        return false;
    }
    struct pel_job_draw *part = picture->user;
    part->picture = picture;
    part->render_ms = busy_ms(loop, part, picture);
    finish_part(loop, part);
    return true;
}

/* --- submitting ---------------------------------------------------------- */

/* How many draws from `first` on, at most `most`, fit the budget now. */
static size_t fitting(struct pel_renderloop *loop, const struct pel_job *job,
                      size_t first, size_t most, size_t *bytes)
{
    size_t held = atomic_load(&loop->held_bytes);
    size_t count = 0;
    *bytes = 0;
    while (count < most && first + count < job->draw_count &&
           !job->parts[first + count].radar) {
        size_t more = job->parts[first + count].bytes;
        bool alone = held == 0 && count == 0;
        if (!alone && held + *bytes + more > READBACK_BUDGET) {
            break;
        }
        *bytes += more;
        count++;
    }
    return count;
}

/* Waits for a picture to be drawn or given back. */
static void wait_room(struct pel_renderloop *loop)
{
    if (in_flight(loop) > 0) {
        collect_one(loop, 5000000);
        return;
    }
    pthread_mutex_lock(&loop->lock);
    pel_cond_wait_ns(&loop->wake, &loop->lock, 2000000);
    pthread_mutex_unlock(&loop->lock);
}

static void note_wrapper(struct pel_renderloop *loop)
{
    pthread_mutex_lock(&loop->lock);
    loop->in_compute = pel_renderer_in_compute(loop->renderer);
    pthread_mutex_unlock(&loop->lock);
}

static void note_submitted(struct pel_job_draw *parts, size_t count,
                           int64_t begun_ns)
{
    int64_t now = pel_now_ns();
    for (size_t i = 0; i < count; i++) {
        parts[i].submitted_ns = now;
        parts[i].submit_ms = (double)(now - begun_ns) * 1e-6 / (double)count;
    }
}

static void say_failed(const struct pel_job *job, enum pel_err err)
{
    static struct pel_log_limit limit;
    pel_log_limited(&limit, PEL_LOG_ERROR, "FRM-003",
                    "frame %llu: drawing failed: %s",
                    (unsigned long long)job->number, pel_err_name(err));
}

/* What the control thread does not wait for: the sea, ship waves and what is
 * afloat in them, cameras too. Gives back: environment.wakes and
 * wash. */
static void stand(struct pel_job *job, size_t first, size_t count)
{
    struct pel_environment *env = &job->environment;
    env->sea = pel_snapshot_sea(job->snapshot);
    env->objects = job->objects;
    env->object_count =
        pel_snapshot_objects(job->snapshot, env->time_s, job->objects);
    env->lamps = job->lamps;
    env->lamp_count =
        pel_snapshot_lamps(job->snapshot, env->time_s, job->objects,
                           env->object_count, job->lamps);
    const struct pel_lightning *l = &job->snapshot->lightning;
    env->storm = l->per_minute > 0 && l->thickness_m > 0;
    env->glow_count = pel_lightning_glows(l, env->time_s, PEL_FALL_SHUTTER_S,
                                          env->glows, PEL_LIGHTNING_GLOWS);
    env->wakes = pel_wakes_at(job->snapshot->wakes, env->time_s);
    env->wash = pel_snapshot_wash(job->snapshot, env->time_s);
    for (size_t i = first; i < first + count; i++) {
        pel_snapshot_camera_in_wakes(job->snapshot, job->parts[i].view,
                                     env->time_s, &job->draws[i].camera);
    }
}

/* Gives the renderer [first, first + count); BUSY: none was taken. */
static enum pel_err submit_some(struct pel_renderloop *loop,
                                struct pel_job *job, size_t first, size_t count,
                                size_t bytes)
{
    size_t before = pel_renderer_in_flight(loop->renderer);
    int64_t begun_ns = pel_now_ns();
    stand(job, first, count);
    atomic_fetch_add(&loop->held_bytes, bytes);
    enum pel_err err = pel_renderer_submit(loop->renderer, &job->environment,
                                           &job->draws[first], count);
    pel_wake_moment_unref(job->environment.wakes);
    job->environment.wakes = NULL;
    pel_wash_destroy(job->environment.wash);
    job->environment.wash = NULL;
    size_t pushed = pel_renderer_in_flight(loop->renderer) - before;
    if (pel_renderer_lost(loop->renderer)) {
        for (size_t i = first + pushed; i < first + count; i++) {
            pel_loss_put_again(loop, &job->parts[i]);
        }
        pel_loss_recover(loop);
        return PEL_OK;
    }
    if (err == PEL_ERR_BUSY && pushed == 0) {
        atomic_fetch_sub(&loop->held_bytes, bytes);
        return err;
    }
    note_submitted(&job->parts[first], count, begun_ns);
    note_wrapper(loop);
    if (err != PEL_OK && pushed < count) {
        say_failed(job, err);
        pel_renderloop_fail(loop, job, first + pushed, count - pushed, err);
    }
    return PEL_OK;
}

/* What losses took, in its order, before anything else. */
static void submit_again(struct pel_renderloop *loop)
{
    while (loop->again_count > 0 && loop->renderer) {
        struct pel_job_draw *part = loop->again[0];
        loop->again_count--;
        memmove(loop->again, loop->again + 1,
                loop->again_count * sizeof *loop->again);
        size_t at = (size_t)(part - part->job->parts);
        if (submit_some(loop, part->job, at, 1, part->bytes) != PEL_OK) {
            atomic_fetch_add(&loop->held_bytes, part->bytes);
            pel_renderloop_fail(loop, part->job, at, 1, PEL_ERR_GPU);
        }
    }
}

static void submit(struct pel_renderloop *loop, struct pel_job *job)
{
    const size_t draws = job->draw_count;
    size_t first = 0, most = draws;
    int refusals = 0; /* with nothing held that could make room */
    loop->submitted++;
    pel_renderloop_progress(loop);
    while (first < draws && !atomic_load(&loop->stop)) {
        size_t bytes;
        if (job->parts[first].radar) {
            finish_part(loop, &job->parts[first++]);
            continue;
        }
        submit_again(loop);
        size_t count = fitting(loop, job, first, most, &bytes);
        if (count == 0) {
            wait_room(loop);
            continue;
        }
        if (submit_some(loop, job, first, count, bytes) == PEL_OK) {
            first += count;
            refusals = 0;
            continue;
        }
        bool alone = atomic_load(&loop->held_bytes) == 0;
        if (alone && count > 1) {
            most = count / 2;
        } else if (alone && ++refusals > MAX_REFUSALS) {
            atomic_fetch_add(&loop->held_bytes, job->parts[first].bytes);
            pel_renderloop_fail(loop, job, first, 1, PEL_ERR_BUSY);
            first++;
        } else {
            wait_room(loop);
        }
    }
}

/* --- a large job, in bands ------------------------------------------------ */

static uint32_t rows_of_band(struct pel_renderloop *loop,
                             const struct pel_camera *c)
{
    uint64_t rows = atomic_load(&loop->band_pixels) / c->width;
    rows = rows / PEL_BAND_ROWS * PEL_BAND_ROWS;
    return rows > PEL_BAND_ROWS ? (uint32_t)rows : PEL_BAND_ROWS;
}

static bool is_wanted(const struct pel_job *job, size_t draw)
{
    for (size_t i = 0; i < job->output_count; i++) {
        if (job->outputs[i].draw == draw &&
            !atomic_load(&job->outputs[i].cancel)) {
            return true;
        }
    }
    return false;
}

/* The next draw; the job has been begun whole with the last. */
static void end_large_draw(struct pel_renderloop *loop)
{
    struct pel_job *job = loop->large;
    loop->large = ++job->begun < job->draw_count ? job : NULL;
}

static void give_up_draw(struct pel_renderloop *loop, enum pel_err err)
{
    struct pel_job_draw *part = &loop->large->parts[loop->large->begun];
    if (part->rows_begun > 0) {
        pel_renderer_drop_bands(loop->renderer);
        atomic_fetch_sub(&loop->held_large, part->bytes);
    }
    part->err = err;
    end_large_draw(loop);
    finish_part(loop, part);
}

static bool has_memory(struct pel_renderloop *loop, struct pel_job_draw *part)
{
    size_t held = atomic_load(&loop->held_large);
    if (part->rows_begun == 0) {
        if (held > 0 && held + part->bytes > READBACK_BUDGET) {
            return false;
        }
        atomic_fetch_add(&loop->held_large, part->bytes);
    }
    return true;
}

static void draw_band(struct pel_renderloop *loop)
{
    struct pel_job *job = loop->large;
    struct pel_job_draw *part = &job->parts[job->begun];
    if (part->radar) {
        end_large_draw(loop);
        finish_part(loop, part);
        return;
    }
    if (pel_loss_noticed(loop)) {
        return;
    }
    if (!is_wanted(job, job->begun) || part->losses > PEL_LOSS_MOST_AGAIN) {
        give_up_draw(loop, part->losses > PEL_LOSS_MOST_AGAIN
                               ? PEL_ERR_GPU
                               : PEL_ERR_CONFLICT);
        return;
    }
    if (!pel_renderer_band_done(loop->renderer, 3000000)) {
        return;
    }
    if (!has_memory(loop, part)) {
        wait_room(loop);
        return;
    }
    int64_t begun_ns = pel_now_ns();
    stand(job, job->begun, 1);
    struct pel_draw draw = job->draws[job->begun];
    uint32_t rows = rows_of_band(loop, &draw.camera);
    uint32_t left = draw.camera.height - part->rows_begun;
    draw.first_row = part->rows_begun;
    draw.rows = rows < left ? rows : left;
    enum pel_err err =
        pel_renderer_submit(loop->renderer, &job->environment, &draw, 1);
    pel_wake_moment_unref(job->environment.wakes);
    job->environment.wakes = NULL;
    pel_wash_destroy(job->environment.wash);
    job->environment.wash = NULL;
    if (pel_renderer_lost(loop->renderer)) {
        part->rows_begun += draw.rows; /* its memory is held */
        pel_loss_recover(loop);
        return;
    }
    if (err == PEL_ERR_BUSY) {
        if (part->rows_begun == 0) {
            atomic_fetch_sub(&loop->held_large, part->bytes);
        }
        wait_room(loop);
        return;
    }
    part->rows_begun += draw.rows;
    part->submitted_ns = pel_now_ns();
    part->submit_ms += (double)(part->submitted_ns - begun_ns) * 1e-6;
    loop->jobs_since = 0;
    pel_renderloop_progress(loop);
    note_wrapper(loop);
    if (err != PEL_OK) {
        say_failed(job, err);
        give_up_draw(loop, err);
    } else if (part->rows_begun == draw.camera.height) {
        end_large_draw(loop);
    }
}

/* --- the thread ---------------------------------------------------------- */

/* Waits while there is nothing to do at all. */
static struct pel_mail *next_mail(struct pel_renderloop *loop)
{
    struct pel_mail *mail = NULL;
    pthread_mutex_lock(&loop->lock);
    while (!atomic_load(&loop->stop)) {
        if (loop->submitted < MAX_SUBMITTED) {
            mail = pel_queue_pop(&loop->queue);
        }
        if (!loop->large) {
            loop->large = loop->given;
            loop->given = NULL;
        }
        if (mail || loop->submitted > 0 || loop->large || in_flight(loop) > 0 ||
            loop->again_count > 0) {
            break;
        }
        pthread_cond_wait(&loop->wake, &loop->lock);
    }
    pthread_mutex_unlock(&loop->lock);
    return mail;
}

static void answer_optics(struct pel_renderloop *loop,
                          struct pel_optics_query *query)
{
    query->environment.sea = pel_snapshot_sea(query->snapshot);
    pel_optics_settle(query);
    for (int i = 0; i <= PEL_LOSS_MOST_AGAIN && loop->renderer; i++) {
        query->fault = (struct pel_fault){ 0 };
        query->err =
            query->question == PELAGOS__OPTICS_QUERY__QUESTION_WATER
                ? pel_renderer_probe_water(loop->renderer, &query->environment,
                                           &query->water.at,
                                           &query->water.light, &query->fault)
                : pel_renderer_probe(loop->renderer, &query->environment,
                                     &query->probe, &query->answer,
                                     &query->fault);
        if (!pel_loss_noticed(loop)) {
            break;
        }
    }
    pel_optics_add_night(query);
    pel_mailbox_post(loop->box, &query->mail);
}

static void draw_jobs(struct pel_renderloop *loop)
{
    while (!atomic_load(&loop->stop)) {
        /* What is finished goes first: software renderers draw while they
         * take commands, and the next job would hold it up for a frame. */
        while (collect_one(loop, 0)) {
        }
        struct pel_mail *mail = next_mail(loop);
        submit_again(loop);
        bool waiting = in_flight(loop) > 0;
        if (mail && mail->kind == PEL_MAIL_OPTICS) {
            answer_optics(loop, (struct pel_optics_query *)mail);
        } else if (mail) {
            submit(loop, (struct pel_job *)mail);
            loop->jobs_since++;
        } else if (loop->large && (!waiting || loop->jobs_since > 0)) {
            draw_band(loop);
        } else if (loop->submitted == MAX_SUBMITTED) {
            collect_one(loop, 50000000);
        } else if (waiting) {
            /* Short, so that a job that comes now is submitted meanwhile. */
            collect_one(loop, 3000000);
        }
        if (mail && loop->large && loop->jobs_since > 0) {
            /* What is there first: nobody waits for it and for a band. */
            while (collect_one(loop, 0)) {
            }
            draw_band(loop);
        }
    }
}

/* Drawing may take every core for a long time; sockets, encoders and surface
 * queries take little and are waited for. Threads of the driver inherit. */
#define RENDER_NICE 5

static void *run(void *argument)
{
    struct pel_renderloop *loop = argument;
    struct pel_fault fault = { 0 };
    /* Linux has a nice value a thread; being nicer is always allowed. */
    setpriority(PRIO_PROCESS, (id_t)gettid(), RENDER_NICE);
    enum pel_err err =
        pel_renderer_create(&loop->options, &loop->renderer, &fault);
    pthread_mutex_lock(&loop->lock);
    if (err == PEL_OK) {
        pel_loss_note_device(loop, 0);
    }
    loop->err = err;
    loop->fault = fault;
    loop->ready = true;
    pthread_cond_broadcast(&loop->wake);
    pthread_mutex_unlock(&loop->lock);
    if (err == PEL_OK) {
        draw_jobs(loop);
        pel_renderer_destroy(loop->renderer);
    }
    pthread_mutex_lock(&loop->lock);
    loop->ended = 1;
    pthread_cond_broadcast(&loop->wake);
    pthread_mutex_unlock(&loop->lock);
    return NULL;
}

enum pel_err pel_renderloop_create(const struct pel_renderer_options *o,
                                   struct pel_encoder_pool *pool,
                                   struct pel_mailbox *box,
                                   struct pel_renderloop **out,
                                   struct pel_fault *fault)
{
    struct pel_renderloop *loop = calloc(1, sizeof *loop);
    if (!loop) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    loop->options = *o;
    loop->pool = pool;
    loop->box = box;
    pel_renderloop_progress(loop);
    pel_lock_init(&loop->lock);
    pel_cond_init(&loop->wake);
    if (pthread_create(&loop->thread, NULL, run, loop) != 0) {
        loop->joined = true;
        pel_renderloop_destroy(loop);
        return pel_fault_set(fault, PEL_ERR_IO, "cannot start a thread");
    }
    pthread_setname_np(loop->thread, "render");
    pthread_mutex_lock(&loop->lock);
    while (!loop->ready) {
        pthread_cond_wait(&loop->wake, &loop->lock);
    }
    enum pel_err err = loop->err;
    pthread_mutex_unlock(&loop->lock);
    if (err != PEL_OK) {
        if (fault) {
            *fault = loop->fault;
        }
        pthread_join(loop->thread, NULL);
        loop->joined = true;
        pel_renderloop_destroy(loop);
        return err;
    }
    *out = loop;
    return PEL_OK;
}

const char *pel_renderloop_device(const struct pel_renderloop *loop)
{
    return loop->devices[atomic_load(&loop->device)];
}

bool pel_renderloop_is_software(const struct pel_renderloop *loop)
{
    return atomic_load(&loop->software);
}

void pel_renderloop_losses(struct pel_renderloop *loop,
                           struct pel_loss_stats *out)
{
    pthread_mutex_lock(&loop->lock);
    *out = loop->losses;
    pthread_mutex_unlock(&loop->lock);
}

static void push(struct pel_renderloop *loop, struct pel_mail *mail)
{
    pthread_mutex_lock(&loop->lock);
    pel_queue_push(&loop->queue, mail);
    pthread_cond_signal(&loop->wake);
    pthread_mutex_unlock(&loop->lock);
}

bool pel_renderloop_in_compute(struct pel_renderloop *loop)
{
    pthread_mutex_lock(&loop->lock);
    bool in_compute = loop->in_compute;
    pthread_mutex_unlock(&loop->lock);
    return in_compute;
}

void pel_renderloop_push(struct pel_renderloop *loop, struct pel_job *job)
{
    if (!job->large) {
        push(loop, &job->mail);
        return;
    }
    pthread_mutex_lock(&loop->lock);
    loop->given = job;
    pthread_cond_signal(&loop->wake);
    pthread_mutex_unlock(&loop->lock);
}

void pel_renderloop_set_band(struct pel_renderloop *loop, uint64_t pixels)
{
    atomic_store(&loop->band_pixels, pixels);
}

void pel_renderloop_push_optics(struct pel_renderloop *loop,
                                struct pel_optics_query *query)
{
    push(loop, &query->mail);
}

void pel_renderloop_released(struct pel_renderloop *loop,
                             const struct pel_job_draw *part)
{
    atomic_fetch_sub(part->job->large ? &loop->held_large : &loop->held_bytes,
                     part->bytes);
    pthread_mutex_lock(&loop->lock);
    pthread_cond_signal(&loop->wake);
    pthread_mutex_unlock(&loop->lock);
}

int64_t pel_renderloop_progress_ns(const struct pel_renderloop *loop)
{
    return atomic_load(&loop->progress_ns);
}

bool pel_renderloop_stop(struct pel_renderloop *loop)
{
    pthread_mutex_lock(&loop->lock);
    atomic_store(&loop->stop, true);
    pthread_cond_broadcast(&loop->wake);
    bool ended =
        pel_cond_wait_ended(&loop->wake, &loop->lock, &loop->ended, 1, STOP_NS);
    pthread_mutex_unlock(&loop->lock);
    if (ended) {
        pthread_join(loop->thread, NULL);
        loop->joined = true;
    }
    return ended;
}

void pel_renderloop_destroy(struct pel_renderloop *loop)
{
    if (loop && loop->joined) {
        pthread_cond_destroy(&loop->wake);
        pthread_mutex_destroy(&loop->lock);
        free(loop);
    }
}
