/* Who may only watch never holds up those who steer or instruct, however many
 * kinds of live views he opens. While there are both, streams of the lower
 * ranks are drawn in the frames of the higher ones as long as these keep their
 * rate, and otherwise behind them: some at a time, in bands between the others
 * (fair.c), encoded by threads of their own. A stream is behind at first, and
 * is not drawn before it is clear that its viewer stays. */
#include "base/clock.h"
#include "frames/core.h"

/* Nobody who leaves sooner has cost a picture. */
#define STAYS_NS 100000000LL
/* Then it is no newcomer any more. */
#define SETTLED_NS 1000000000LL
#define BESIDE_FIRST 8 /* a wall of windows */
#define BESIDE_MORE 4
/* Of the period, what frames take: */
#define LATE 1.2
#define CALM 0.8
#define WAIT_NS 2000000000LL
#define WAIT_MAX_NS 64000000000LL
#define TAKEN_BACK_NS 10000000000LL
#define MOST_JOBS 2 /* whose pictures of low ranks wait to be encoded */

void pel_lanes_begin(struct pel_lanes *lanes)
{
    *lanes = (struct pel_lanes){ .beside = BESIDE_FIRST, .wait_ns = WAIT_NS };
}

static bool is_low(const struct pel_who *who)
{
    return who->rank >= PEL_RANK_WATCH;
}

static enum pel_lane lane_of(const struct pel_lanes *lanes,
                             const struct pel_stream *stream, bool low,
                             int64_t now_ns, unsigned *beside)
{
    if (!lanes->split || !low) {
        return PEL_LANE_FRONT;
    }
    if (now_ns - stream->opened_ns < SETTLED_NS || *beside >= lanes->beside) {
        return PEL_LANE_BEHIND;
    }
    ++*beside;
    return PEL_LANE_BESIDE;
}

void pel_lanes_sort(struct pel_frames *frames)
{
    struct pel_lanes *lanes = &frames->lanes;
    struct pel_who owners[PEL_MAX_STREAMS];
    bool high = false, low = false;
    unsigned beside = 0;
    int64_t now_ns = pel_now_ns();
    pel_live_owners(frames, owners);
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        const struct pel_stream *s = &frames->streams[i];
        bool runs = s->serial && s->paused < s->subscribers;
        high = high || (runs && !is_low(&owners[i]));
        low = low || (runs && is_low(&owners[i]));
    }
    lanes->high = high;
    lanes->split = high && low;
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        struct pel_stream *s = &frames->streams[i];
        if (s->serial) {
            s->lane = lane_of(lanes, s, is_low(&owners[i]), now_ns, &beside);
            bool its = s->lane != PEL_LANE_FRONT;
            if (its != s->low && !pel_live_under_way(frames, s->serial)) {
                s->low = its; /* its encoder has pictures in their order */
            }
        }
    }
}

bool pel_lanes_full(const struct pel_frames *frames)
{
    int jobs = 0;
    for (int i = 0; i < frames->job_count; i++) {
        const struct pel_job *job = &frames->jobs[i];
        bool waits = false;
        for (size_t k = 0; job->used && k < job->output_count && !waits; k++) {
            waits = job->outputs[k].stream && job->outputs[k].low &&
                    !job->outputs[k].delivered;
        }
        jobs += waits;
    }
    return jobs >= MOST_JOBS;
}

struct pel_stream *pel_lanes_next(struct pel_frames *frames, uint64_t turn)
{
    struct pel_stream *next = NULL;
    int64_t latest_ns = pel_now_ns() - STAYS_NS;
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        struct pel_stream *s = &frames->streams[i];
        if (s->serial && s->lane == PEL_LANE_BEHIND && s->turn != turn &&
            s->opened_ns < latest_ns && s->paused < s->subscribers &&
            (!next || s->turn < next->turn)) {
            next = s;
        }
    }
    return next;
}

void pel_lanes_feed(struct pel_lanes *lanes, double busy_ms, double period_ms,
                    int64_t now_ns)
{
    if (!lanes->split) {
        return;
    }
    if (busy_ms > LATE * period_ms) {
        bool taken_back = now_ns - lanes->more_ns < TAKEN_BACK_NS;
        lanes->wait_ns =
            taken_back ? MIN(2 * lanes->wait_ns, WAIT_MAX_NS) : lanes->wait_ns;
        lanes->more_ns = 0;
        lanes->beside /= 2;
        lanes->calm_ns = 0;
    } else if (busy_ms > CALM * period_ms) {
        lanes->calm_ns = 0;
    } else if (lanes->calm_ns == 0) {
        lanes->calm_ns = now_ns;
    } else if (now_ns - lanes->calm_ns > lanes->wait_ns &&
               lanes->beside < PEL_MAX_STREAMS) {
        lanes->beside += BESIDE_MORE;
        lanes->more_ns = lanes->calm_ns = now_ns;
    }
}
