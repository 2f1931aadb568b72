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
#include "proto/formats.h"

/* Readback memory in flight or with the encoders, of large jobs and of the
 * others; one picture always fits. */
#define READBACK_BUDGET ((size_t)256 << 20)
#define MAX_SUBMITTED 2
/* So long after the last picture what large ones took goes back. */
#define REST_NS 5000000000
#define MAX_REFUSALS 100 /* 2 ms apart */
#define STOP_NS 2000000000LL
/* A software device compiles and draws on this process's threads, for seconds
 * where programs are new, and takes one part in LEAST_SHARE of a processor at
 * least, were 20 others at work on each; one that hangs waits, or computes for
 * longer than any picture takes. */
#define LEAST_SHARE 25
#define MOST_COMPUTED_NS 60000000000LL
#define MOST_SILENT_NS 120000000000LL

static int64_t read_ns(clockid_t clock)
{
    struct timespec t = { 0 };
    clock_gettime(clock, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* Of processors, by this process without the control thread, which answers
 * clients whatever the renderer does. */
static int64_t used_ns(const struct pel_renderloop *loop)
{
    return read_ns(CLOCK_PROCESS_CPUTIME_ID) - read_ns(loop->control);
}

void pel_renderloop_progress(struct pel_renderloop *loop)
{
    atomic_store(&loop->progress_used_ns, used_ns(loop));
    atomic_store(&loop->progress_ns, pel_now_ns());
}

void pel_parts_put(struct pel_parts *parts, struct pel_job_draw *part)
{
    part->next = NULL;
    if (parts->first) {
        parts->last->next = part;
    } else {
        parts->first = part;
    }
    parts->last = part;
}

struct pel_job_draw *pel_parts_take(struct pel_parts *parts)
{
    struct pel_job_draw *part = parts->first;
    if (part) {
        parts->first = part->next;
    }
    return part;
}

static uint64_t pixels_of(const struct pel_job_draw *part)
{
    const struct pel_camera *c =
        &part->job->draws[part - part->job->parts].camera;
    return part->radar ? 0 : (uint64_t)c->width * c->height;
}

/* --- one picture is there ------------------------------------------------ */

/* It is no more this loop's. */
static void let_go(struct pel_renderloop *loop, struct pel_job_draw *part)
{
    struct pel_share *share = part->share;
    atomic_fetch_sub(&loop->work, pixels_of(part));
    part->share = NULL;
    if (share && --share->left == 0) {
        loop->submitted--;
        atomic_fetch_sub(&loop->shares, 1);
    }
}

/* Its outputs go to the encoders; after the last picture the job goes back. */
static void finish_part(struct pel_renderloop *loop, struct pel_job_draw *part)
{
    struct pel_job *job = part->job;
    size_t draw = (size_t)(part - job->parts);
    let_go(loop, part);
    /* From the last picture on the job is the control thread's. */
    size_t outputs = job->output_count, draws = job->draw_count;
    for (size_t i = 0; i < outputs; i++) {
        if (job->outputs[i].draw == draw) {
            pel_encoder_pool_push_output(loop->pool, &job->outputs[i]);
        }
    }
    pel_renderloop_progress(loop);
    if (atomic_fetch_add(&job->collected, 1) + 1 == draws) {
        loop->large_drawn = loop->large_drawn == job ? NULL : loop->large_drawn;
        pel_job_settle(job);
        job->drawn_ns = pel_now_ns();
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

void pel_renderloop_fail(struct pel_renderloop *loop, struct pel_job_draw *part,
                         enum pel_err err)
{
    atomic_fetch_sub(&loop->held_bytes, part->bytes);
    part->err = err;
    finish_part(loop, part);
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
    part->device = loop->device;
    part->device_name = loop->devices[atomic_load(&loop->device_now)];
    part->render_ms = busy_ms(loop, part, picture);
    finish_part(loop, part);
    return true;
}

/* --- submitting ---------------------------------------------------------- */

/* The next draw of the share in hand but `ahead`. */
static struct pel_job_draw *part_ahead(const struct pel_renderloop *loop,
                                       size_t ahead)
{
    return &loop->share->job->parts[loop->share->draws[loop->at + ahead]];
}

/* How many of the next draws in hand, at most `most`, all of one place, fit the
 * budget now. */
static size_t fitting(struct pel_renderloop *loop, size_t most)
{
    size_t bytes = atomic_load(&loop->held_bytes);
    size_t count = 0;
    while (count < most && loop->at + count < loop->end &&
           !part_ahead(loop, count)->radar &&
           part_ahead(loop, count)->place == part_ahead(loop, 0)->place) {
        size_t more = part_ahead(loop, count)->bytes;
        bool alone = bytes == 0;
        if (!alone && bytes + more > READBACK_BUDGET) {
            break;
        }
        bytes += more;
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

static void note_submitted(struct pel_job_draw *const *parts, size_t count,
                           int64_t begun_ns)
{
    int64_t now = pel_now_ns();
    for (size_t i = 0; i < count; i++) {
        parts[i]->submitted_ns = now;
        parts[i]->submit_ms = (double)(now - begun_ns) * 1e-6 / (double)count;
    }
}

static void say_failed(const struct pel_job *job, enum pel_err err)
{
    static struct pel_log_limit limit;
    pel_log_limited(&limit, PEL_LOG_ERROR, "FRM-003",
                    "frame %llu: drawing failed: %s",
                    (unsigned long long)job->number, pel_err_name(err));
}

/* What all who take this picture take it as. */
static void choose_form(const struct pel_job *job, size_t draw,
                        struct pel_draw *out)
{
    bool video = false, pictures = false, same = true;
    int quality = 0;
    out->ycbcr = PEL_YCBCR_NONE;
    for (size_t i = 0; i < job->output_count; i++) {
        const struct pel_output *output = &job->outputs[i];
        if (output->draw != draw) {
            continue;
        }
        if (!output->track &&
            !(pel_format_of(output->format)->uses & PEL_FORMAT_PLANES)) {
            return;
        }
        same = same && (!pictures || output->quality == quality);
        quality = output->quality;
        video = video || output->track;
        pictures = pictures || !output->track;
    }
    if (video != pictures) {
        const struct pel_job_draw *part = &job->parts[draw];
        bool whole = part->width == out->camera.width &&
                     part->height == out->camera.height;
        bool coded = whole && same && quality <= PEL_JPEG_BEST;
        out->quality = quality;
        out->ycbcr = video   ? PEL_YCBCR_VIDEO
                     : coded ? PEL_YCBCR_CODED
                             : PEL_YCBCR_JPEG;
    }
}

/* Gives the renderer draws of one job; BUSY: none was taken. */
static enum pel_err submit_some(struct pel_renderloop *loop,
                                struct pel_job_draw *const *parts, size_t count)
{
    struct pel_job *job = parts[0]->job;
    size_t before = pel_renderer_in_flight(loop->renderer), bytes = 0;
    int64_t begun_ns = pel_now_ns();
    pel_job_stand(job);
    for (size_t i = 0; i < count; i++) {
        size_t draw = (size_t)(parts[i] - job->parts);
        loop->draws[i] = job->draws[draw];
        choose_form(job, draw, &loop->draws[i]);
        bytes += parts[i]->bytes;
    }
    atomic_fetch_add(&loop->held_bytes, bytes);
    enum pel_err err = pel_renderer_submit(
        loop->renderer,
        pel_job_environment(job, (size_t)(parts[0] - job->parts)), loop->draws,
        count);
    size_t pushed = pel_renderer_in_flight(loop->renderer) - before;
    if (pel_renderer_lost(loop->renderer)) {
        for (size_t i = pushed; i < count; i++) {
            pel_loss_put_again(loop, parts[i]);
        }
        return PEL_OK; /* who calls asks for losses */
    }
    if (err == PEL_ERR_BUSY && pushed == 0) {
        atomic_fetch_sub(&loop->held_bytes, bytes);
        return err;
    }
    note_submitted(parts, count, begun_ns);
    note_wrapper(loop);
    if (err != PEL_OK && pushed < count) {
        say_failed(job, err);
        for (size_t i = pushed; i < count; i++) {
            pel_renderloop_fail(loop, parts[i], err);
        }
    }
    return PEL_OK;
}

/* What losses took, in its order, before anything else. */
static void submit_again(struct pel_renderloop *loop)
{
    struct pel_job_draw *part = NULL;
    while (loop->renderer && (part = pel_parts_take(&loop->again))) {
        if (part->radar) {
            finish_part(loop, part);
            continue;
        }
        if (submit_some(loop, &part, 1) != PEL_OK) {
            atomic_fetch_add(&loop->held_bytes, part->bytes);
            pel_renderloop_fail(loop, part, PEL_ERR_GPU);
        }
        pel_loss_noticed(loop);
    }
}

/* The next `count` draws in hand; BUSY: as submit_some. A loss takes what is
 * left in hand, too, where a peer can draw it. */
static enum pel_err submit_next(struct pel_renderloop *loop, size_t count)
{
    struct pel_job_draw *parts[PEL_MAX_VIEWS];
    for (size_t i = 0; i < count; i++) {
        parts[i] = part_ahead(loop, i);
    }
    enum pel_err err = submit_some(loop, parts, count);
    if (err == PEL_OK) {
        loop->at += count;
        pel_loss_noticed(loop);
    }
    return err;
}

static void submit(struct pel_renderloop *loop, struct pel_share *share)
{
    size_t most = share->count;
    int refusals = 0; /* with nothing held that could make room */
    loop->submitted++;
    loop->share = share;
    loop->at = 0;
    loop->end = share->count;
    pel_renderloop_progress(loop);
    while (loop->at < loop->end && !atomic_load(&loop->stop)) {
        if (part_ahead(loop, 0)->radar) {
            finish_part(loop, part_ahead(loop, 0));
            loop->at++;
            continue;
        }
        submit_again(loop);
        size_t count = loop->at < loop->end ? fitting(loop, most) : 0;
        if (count == 0) {
            wait_room(loop);
            continue;
        }
        if (submit_next(loop, count) == PEL_OK) {
            refusals = 0;
            continue;
        }
        bool alone = atomic_load(&loop->held_bytes) == 0;
        if (alone && count > 1) {
            most = count / 2;
        } else if (alone && ++refusals > MAX_REFUSALS) {
            struct pel_job_draw *part = part_ahead(loop, 0);
            atomic_fetch_add(&loop->held_bytes, part->bytes);
            loop->at++;
            pel_renderloop_fail(loop, part, PEL_ERR_BUSY);
        } else {
            wait_room(loop);
        }
    }
    loop->share = NULL;
}

/* --- what a peer draws instead -------------------------------------------- */

static void push(struct pel_renderloop *loop, struct pel_mail *mail)
{
    pthread_mutex_lock(&loop->lock);
    pel_queue_push(&loop->queue, mail);
    pthread_mutex_unlock(&loop->lock);
    pthread_cond_signal(&loop->wake);
}

/* Before it is pushed. */
static void note_work(struct pel_renderloop *loop, uint64_t pixels)
{
    if (atomic_fetch_add(&loop->work, pixels) == 0) {
        atomic_store(&loop->awake_ns, pel_now_ns());
    }
}

/* What is left of it. */
static uint64_t large_pixels(const struct pel_job *job)
{
    uint64_t pixels = 0;
    for (size_t i = job->begun; i < job->draw_count; i++) {
        pixels += pixels_of(&job->parts[i]);
    }
    return pixels;
}

static void hand_large(struct pel_renderloop *loop, struct pel_renderloop *to,
                       struct pel_job *job)
{
    atomic_fetch_sub(&loop->work, large_pixels(job));
    pel_renderloop_push_large(to, job);
}

static struct pel_renderloop *peer_that_stands(struct pel_renderloop *loop)
{
    struct pel_renderloop *best = NULL;
    for (size_t i = 0; i < loop->peer_count; i++) {
        struct pel_renderloop *p = loop->peers[i];
        if (p != loop && pel_renderloop_stands(p) &&
            (!best || pel_renderloop_work(p) < pel_renderloop_work(best))) {
            best = p;
        }
    }
    return best;
}

/* Where none stands they wait here. */
static void hand_all(struct pel_renderloop *loop, struct pel_parts parts)
{
    struct pel_job_draw *part;
    while ((part = pel_parts_take(&parts))) {
        struct pel_renderloop *to = peer_that_stands(loop);
        to = to ? to : loop;
        let_go(loop, part);
        note_work(to, pixels_of(part));
        pthread_mutex_lock(&to->lock);
        pel_parts_put(&to->handed, part);
        pthread_mutex_unlock(&to->lock);
        pthread_cond_signal(&to->wake);
    }
}

static void put_draws(const struct pel_share *share, size_t from, size_t count,
                      struct pel_parts *out)
{
    for (size_t i = from; i < count; i++) {
        pel_parts_put(out, &share->job->parts[share->draws[i]]);
    }
}

/* What waits in the queue; questions of light to `to`. */
static void take_queue(struct pel_renderloop *loop, struct pel_renderloop *to,
                       struct pel_parts *out)
{
    for (;;) {
        pthread_mutex_lock(&loop->lock);
        struct pel_mail *mail = pel_queue_pop(&loop->queue);
        pthread_mutex_unlock(&loop->lock);
        if (!mail) {
            return;
        }
        if (mail->kind == PEL_MAIL_OPTICS) {
            push(to, mail);
        } else {
            const struct pel_share *share = (struct pel_share *)mail;
            loop->submitted++; /* let_go takes it away */
            put_draws(share, 0, share->count, out);
        }
    }
}

bool pel_renderloop_pass_on(struct pel_renderloop *loop)
{
    struct pel_renderloop *to = peer_that_stands(loop);
    if (!to) {
        return false;
    }
    struct pel_parts parts = loop->again;
    loop->again = (struct pel_parts){ 0 };
    hand_all(loop, parts);
    pthread_mutex_lock(&loop->lock);
    parts = loop->handed;
    loop->handed = (struct pel_parts){ 0 };
    struct pel_queue given = loop->given;
    loop->given = (struct pel_queue){ 0 };
    pthread_mutex_unlock(&loop->lock);
    hand_all(loop, parts);
    parts = (struct pel_parts){ 0 };
    if (loop->share) {
        put_draws(loop->share, loop->at, loop->end, &parts);
        loop->end = loop->at;
    }
    take_queue(loop, to, &parts);
    hand_all(loop, parts);
    if (loop->large) {
        hand_large(loop, to, loop->large);
        loop->large = NULL;
        loop->large_drawn = NULL;
    }
    struct pel_mail *mail;
    while ((mail = pel_queue_pop(&given))) {
        hand_large(loop, to, (struct pel_job *)mail);
    }
    return true;
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
    pel_job_stand(job);
    struct pel_draw draw = job->draws[job->begun];
    uint32_t rows = rows_of_band(loop, &draw.camera);
    uint32_t left = draw.camera.height - part->rows_begun;
    draw.first_row = part->rows_begun;
    draw.rows = rows < left ? rows : left;
    enum pel_err err = pel_renderer_submit(
        loop->renderer, pel_job_environment(job, job->begun), &draw, 1);
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

/* With the lock. */
static void take_handed(struct pel_renderloop *loop)
{
    struct pel_job_draw *part;
    while ((part = pel_parts_take(&loop->handed))) {
        pel_parts_put(&loop->again, part);
    }
}

/* Waits while there is nothing to do at all, or until it is time to rest. */
static struct pel_mail *next_mail(struct pel_renderloop *loop)
{
    struct pel_mail *mail = NULL;
    pthread_mutex_lock(&loop->lock);
    while (!atomic_load(&loop->stop)) {
        if (loop->submitted < MAX_SUBMITTED) {
            mail = pel_queue_pop(&loop->queue);
        }
        take_handed(loop);
        if (!loop->large_drawn) {
            loop->large = (struct pel_job *)pel_queue_pop(&loop->given);
            loop->large_drawn = loop->large;
        }
        if (mail || loop->submitted > 0 || loop->large || in_flight(loop) > 0 ||
            loop->again.first) {
            break;
        }
        int64_t begun_ns = pel_now_ns();
        if (!loop->drew) {
            pthread_cond_wait(&loop->wake, &loop->lock);
            continue;
        }
        pel_cond_wait_ns(&loop->wake, &loop->lock, REST_NS);
        if (pel_now_ns() - begun_ns >= REST_NS) {
            break;
        }
    }
    pthread_mutex_unlock(&loop->lock);
    return mail;
}

static bool is_idle(struct pel_renderloop *loop, const struct pel_mail *mail)
{
    return !mail && loop->submitted == 0 && !loop->large &&
           in_flight(loop) == 0 && !loop->again.first && !loop->large_drawn;
}

static void answer_optics(struct pel_renderloop *loop,
                          struct pel_optics_query *query)
{
    pel_optics_settle(query);
    query->environment.sea = pel_snapshot_sea(query->snapshot);
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
    struct pel_renderloop *peer =
        loop->renderer ? NULL : peer_that_stands(loop);
    if (peer) {
        push(peer, &query->mail);
        return;
    }
    pel_optics_conclude(query);
    pel_mailbox_post(loop->box, &query->mail);
}

static void draw_jobs(struct pel_renderloop *loop)
{
    while (!atomic_load(&loop->stop)) {
        if (!loop->renderer) {
            pel_loss_return(loop);
            continue;
        }
        /* What is finished goes first: software renderers draw while they
         * take commands, and the next job would hold it up for a frame. */
        while (collect_one(loop, 0)) {
        }
        struct pel_mail *mail = next_mail(loop);
        if (is_idle(loop, mail)) {
            pel_renderer_rest(loop->renderer);
            loop->drew = false;
            continue;
        }
        loop->drew = true;
        submit_again(loop);
        bool waiting = in_flight(loop) > 0;
        if (mail && mail->kind == PEL_MAIL_OPTICS) {
            answer_optics(loop, (struct pel_optics_query *)mail);
        } else if (mail) {
            submit(loop, (struct pel_share *)mail);
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
        atomic_store(&loop->standing, true);
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

enum pel_err
pel_renderloop_create(const struct pel_renderer_options *o, unsigned device,
                      struct pel_encoder_pool *pool, struct pel_mailbox *box,
                      struct pel_renderloop **out, struct pel_fault *fault)
{
    struct pel_renderloop *loop = calloc(1, sizeof *loop);
    if (!loop) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    loop->options = *o;
    loop->device = device;
    loop->pool = pool;
    loop->box = box;
    if (pthread_getcpuclockid(pthread_self(), &loop->control) != 0) {
        loop->control = CLOCK_THREAD_CPUTIME_ID;
    }
    pel_renderloop_progress(loop);
    pel_lock_init(&loop->lock);
    pel_cond_init(&loop->wake);
    if (pthread_create(&loop->thread, NULL, run, loop) != 0) {
        loop->joined = true;
        pel_renderloop_destroy(loop);
        return pel_fault_set(fault, PEL_ERR_IO, "cannot start a thread");
    }
    pthread_setname_np(loop->thread, "render");
    *out = loop;
    return PEL_OK;
}

enum pel_err pel_renderloop_wait(struct pel_renderloop *loop,
                                 struct pel_renderloop *const *peers,
                                 size_t count, struct pel_fault *fault)
{
    pthread_mutex_lock(&loop->lock);
    while (!loop->ready) {
        pthread_cond_wait(&loop->wake, &loop->lock);
    }
    enum pel_err err = loop->err;
    loop->peers = peers; /* it has drawn nothing yet */
    loop->peer_count = count;
    pthread_mutex_unlock(&loop->lock);
    if (err != PEL_OK && fault) {
        *fault = loop->fault;
    }
    return err;
}

const char *pel_renderloop_device(const struct pel_renderloop *loop)
{
    return loop->devices[atomic_load(&loop->device_now)];
}

bool pel_renderloop_stands(const struct pel_renderloop *loop)
{
    return atomic_load(&loop->standing);
}

uint64_t pel_renderloop_work(const struct pel_renderloop *loop)
{
    return atomic_load(&loop->work);
}

unsigned pel_renderloop_shares(const struct pel_renderloop *loop)
{
    return atomic_load(&loop->shares);
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

bool pel_renderloop_in_compute(struct pel_renderloop *loop)
{
    pthread_mutex_lock(&loop->lock);
    bool in_compute = loop->in_compute;
    pthread_mutex_unlock(&loop->lock);
    return in_compute;
}

void pel_renderloop_push(struct pel_renderloop *loop, struct pel_share *share)
{
    struct pel_job *job = share->job;
    uint64_t pixels = 0;
    share->left = share->count;
    for (size_t i = 0; i < share->count; i++) {
        struct pel_job_draw *part = &job->parts[share->draws[i]];
        part->share = share;
        pixels += pixels_of(part);
    }
    note_work(loop, pixels);
    atomic_fetch_add(&loop->shares, 1);
    share->mail.kind = PEL_MAIL_JOB_DRAWN;
    push(loop, &share->mail);
}

void pel_renderloop_push_large(struct pel_renderloop *loop, struct pel_job *job)
{
    note_work(loop, large_pixels(job));
    pthread_mutex_lock(&loop->lock);
    pel_queue_push(&loop->given, &job->mail);
    pthread_mutex_unlock(&loop->lock);
    pthread_cond_signal(&loop->wake);
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
    /* Without the lock: who waits for room looks again within 2 ms. */
    pthread_cond_signal(&loop->wake);
}

int64_t pel_renderloop_progress_ns(const struct pel_renderloop *loop)
{
    int64_t progress_ns = atomic_load(&loop->progress_ns);
    int64_t awake_ns = atomic_load(&loop->awake_ns);
    return pel_renderloop_work(loop) == 0 ? pel_now_ns()
           : awake_ns > progress_ns       ? awake_ns
                                          : progress_ns;
}

bool pel_renderloop_computes(const struct pel_renderloop *loop)
{
    int64_t silent = pel_now_ns() - pel_renderloop_progress_ns(loop);
    int64_t used = used_ns(loop) - atomic_load(&loop->progress_used_ns);
    return pel_renderloop_is_software(loop) && silent < MOST_SILENT_NS &&
           used > silent / LEAST_SHARE && used < MOST_COMPUTED_NS;
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
    } else {
        pthread_detach(loop->thread); /* it is left to itself */
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
