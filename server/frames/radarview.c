#include "frames/radarview.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "models/model.h"
#include "ocean/sea.h"
#include "optics/radar.h"
#include "seabed/seabed.h"

#define TURN (2 * PEL_PI)
#define LEAST_HEIGHT_M 2.0
/* The sea's height field where there is clutter: nodes by bearing and range. */
#define HEAVE_M 4500.0
#define HEAVE_BEARINGS 160
#define HEAVE_RANGES 150
#define HEAVE_POINTS (HEAVE_BEARINGS * HEAVE_RANGES)
/* Parts that a hull is, along her. */
#define HULL_PARTS 7
#define MOST_CELLS 1024U
#define ROWS 64U /* between looks at whether it is still wanted */

/* The sea at the beginning of a turn, about the ship as she was then. */
struct heave {
    int64_t turn;
    bool made;
    float slope[HEAVE_POINTS]; /* towards the radar, standard deviations */
};

struct seen {
    const struct pel_snapshot *s;
    const struct pel_view_state *view;
    struct pel_radar radar;
    double time_s;
    int64_t turn; /* of `east_m`, `north_m` */
    double bearing_rad, east_m, north_m;
    struct heave heave[2]; /* by the parity of the turn */
};

/* One picture at a time: what is large is here. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct seen seen;

/* The antenna's place, level, and the heading there. */
static double stand(const struct pel_snapshot *s,
                    const struct pel_view_state *view, double time_s,
                    double *east_m, double *north_m)
{
    struct pel_entity_state e = { 0 };
    if (view->place.stand != PEL_STAND_CARRIED) {
        struct pel_stance at;
        pel_view_stance(s, (size_t)(view - s->views), time_s, false, &at);
        *east_m = at.east_m;
        *north_m = at.north_m;
        return atan2(at.axes.y.x, at.axes.y.y);
    }
    if (view->entity >= 0) {
        pel_snapshot_entity_level(s, (size_t)view->entity, time_s, &e);
    }
    double sine = sin(e.heading_rad), cosine = cos(e.heading_rad);
    *east_m = e.east_m + view->forward_m * sine + view->right_m * cosine;
    *north_m = e.north_m + view->forward_m * cosine - view->right_m * sine;
    return e.heading_rad;
}

/* As it stood when the antenna passed this bearing. */
static void stand_at(struct seen *a, double bearing_rad, int64_t turn)
{
    if (turn == a->turn && bearing_rad == a->bearing_rad) {
        return;
    }
    a->turn = turn;
    a->bearing_rad = bearing_rad;
    stand(a->s, a->view, ((double)turn + bearing_rad / TURN) * a->radar.turn_s,
          &a->east_m, &a->north_m);
}

static void make_heave(struct seen *a, struct heave *h, int64_t turn)
{
    static struct pel_vec2 points[HEAVE_POINTS];
    static struct pel_surface_sample samples[HEAVE_POINTS];
    double east, north, time = (double)turn * a->radar.turn_s, sum = 0;
    stand(a->s, a->view, time, &east, &north);
    for (int i = 0; i < HEAVE_POINTS; i++) {
        double bearing = TURN * (i / HEAVE_RANGES + 0.5) / HEAVE_BEARINGS;
        double range = HEAVE_M * (i % HEAVE_RANGES + 0.5) / HEAVE_RANGES;
        points[i] = (struct pel_vec2){ east + range * sin(bearing),
                                       north + range * cos(bearing) };
    }
    pel_sea_query(pel_snapshot_sea(a->s), points, HEAVE_POINTS, time, samples);
    for (int i = 0; i < HEAVE_POINTS; i++) {
        double bearing = TURN * (i / HEAVE_RANGES + 0.5) / HEAVE_BEARINGS;
        struct pel_vec3 n = samples[i].normal;
        /* Faces that lean towards the radar. */
        double s = -(n.x * sin(bearing) + n.y * cos(bearing)) / n.z;
        h->slope[i] = (float)s;
        sum += s * s;
    }
    double deviation = sqrt(sum / HEAVE_POINTS) + 1e-9;
    for (int i = 0; i < HEAVE_POINTS; i++) {
        h->slope[i] /= (float)deviation;
    }
    h->turn = turn;
    h->made = true;
}

static double slope_at(void *user, double bearing_rad, double range_m,
                       int64_t turn)
{
    struct seen *a = user;
    struct heave *h = &a->heave[turn & 1];
    if (!h->made || h->turn != turn) {
        make_heave(a, h, turn);
    }
    if (range_m >= HEAVE_M) {
        return 0.6; /* its factor is 1 */
    }
    int row = (int)(bearing_rad / TURN * HEAVE_BEARINGS) % HEAVE_BEARINGS;
    int cell = (int)(range_m / HEAVE_M * HEAVE_RANGES);
    return (double)h->slope[row * HEAVE_RANGES + cell];
}

static double land_at(void *user, double bearing_rad, double range_m,
                      int64_t turn)
{
    struct seen *a = user;
    stand_at(a, bearing_rad, turn);
    return pel_seabed_drawn(a->s->seabed,
                            a->east_m + range_m * sin(bearing_rad),
                            a->north_m + range_m * cos(bearing_rad), -100) -
           a->s->sea_level_m;
}

/* --- things on the sea ---------------------------------------------------- */

/* Marks carry reflectors; of the smallest things the class says what they are
 * at least. */
static double least_of(const struct pel_model *m)
{
    return m->class >= PEL_MODEL_LATERAL_PORT ? 10 : m->length_m < 3 ? 0.3 : 3;
}

/* Bearing and range of a point of the hull, when the antenna passed it in the
 * turn before or after `turns` of the present one. */
static bool pass(struct seen *a, size_t entity, double along_m, int turns,
                 struct pel_radar_point *p)
{
    struct pel_entity_state e;
    double when = a->time_s, east, north;
    int64_t now, turn;
    for (int i = 0; i < 4; i++) { /* to where it was as it was passed */
        pel_snapshot_entity_level(a->s, entity, when, &e);
        stand(a->s, a->view, when, &east, &north);
        double x = e.east_m + along_m * sin(e.heading_rad) - east;
        double y = e.north_m + along_m * cos(e.heading_rad) - north;
        p->bearing_rad = atan2(x, y);
        p->bearing_rad += p->bearing_rad < 0 ? TURN : 0;
        p->range_m = hypot(x, y);
        when = pel_radar_passed(&a->radar, p->bearing_rad, a->time_s, &turn);
        when += turns * a->radar.turn_s;
    }
    /* Beams that the antenna is in have both of their turns. */
    pel_radar_passed(&a->radar, p->bearing_rad, a->time_s, &now);
    p->turn = now + turns;
    double aspect = p->bearing_rad + PEL_PI - e.heading_rad;
    const struct pel_model *m = e.model;
    p->sigma = pel_radar_ship(m->length_m, m->beam_m, m->draught_m, aspect,
                              least_of(m));
    p->height_m = fmax(0.5 * m->height_m, 0.5);
    return p->range_m > 1 && p->range_m < a->radar.range_m;
}

static void add_things(struct seen *a, struct pel_radar_scan *scan)
{
    for (size_t i = 0; i < a->s->entity_count; i++) {
        const struct pel_model *m = a->s->entities[i].model;
        if (!m || (int)i == a->view->entity) {
            continue;
        }
        int parts = m->length_m > 30 ? HULL_PARTS : 1;
        for (int k = 0; k < parts; k++) {
            double along =
                parts > 1 ? m->length_m * ((k + 0.5) / parts - 0.5) : 0;
            for (int turns = -1; turns <= 1; turns++) {
                struct pel_radar_point p = {
                    .id = a->s->entities[i].id * HULL_PARTS + (uint32_t)k
                };
                if (pass(a, i, along, turns, &p)) {
                    p.sigma /= parts;
                    pel_radar_add(&a->radar, a->time_s, &p, scan);
                }
            }
        }
    }
}

/* --- the picture ---------------------------------------------------------- */

/* Pulses as sets choose them by range. */
static double pulse_of(const struct pel_radar_set *set)
{
    return set->pulse_s > 0           ? set->pulse_s
           : set->range_m < 3 * 1852  ? 0.08e-6
           : set->range_m < 12 * 1852 ? 0.3e-6
                                      : 0.8e-6;
}

static void begin(struct seen *a, const struct pel_snapshot *s, size_t view,
                  double time_s)
{
    const struct pel_radar_set *set = &s->views[view].radar;
    const struct pel_sea *sea = pel_snapshot_sea(s);
    a->s = s;
    a->view = &s->views[view];
    a->time_s = time_s;
    a->turn = INT64_MIN;
    a->heave[0].made = a->heave[1].made = false;
    struct pel_entity_state e = { 0 };
    if (a->view->entity >= 0) {
        pel_snapshot_entity_level(s, (size_t)a->view->entity, time_s, &e);
    }
    double height = e.afloat ? a->view->up_m
                             : e.altitude_m + a->view->up_m - s->sea_level_m;
    if (a->view->place.stand != PEL_STAND_CARRIED) {
        struct pel_stance at;
        pel_view_stance(s, (size_t)(a->view - s->views), a->time_s, false, &at);
        height = at.altitude_m - s->sea_level_m;
    }
    a->radar = (struct pel_radar){
        .range_m = set->range_m,
        .pulse_s = pulse_of(set),
        .beam_rad = set->beam_rad,
        .turn_s = set->turn_s,
        .height_m = fmax(height, LEAST_HEIGHT_M),
        .rain_mm_h = set->rain_mm_h,
        .wave_m = 0.63 * 4 * sqrt(sea->m0),
        .wind_to_rad = s->wind_to_rad,
        .seed = sea->desc.seed,
    };
}

enum pel_err pel_radar_view_show(const struct pel_snapshot *s, size_t view,
                                 double time_s, uint32_t width, uint32_t height,
                                 const atomic_bool *cancel, uint8_t *rgba)
{
    struct pel_radar_scan *scan;
    uint32_t side = width < height ? width : height;
    int cells = (int)(side / 2 < MOST_CELLS ? side / 2 : MOST_CELLS);
    enum pel_err err = pel_radar_scan_create(cells, &scan);
    if (err != PEL_OK) {
        return err;
    }
    begin(&seen, s, view, time_s);
    pel_radar_fill(&seen.radar, time_s, slope_at, &seen, scan);
    add_things(&seen, scan);
    if (s->seabed) {
        pel_radar_add_land(&seen.radar, time_s, land_at, &seen, scan);
    }
    double east, north;
    double heading = stand(s, seen.view, time_s, &east, &north);
    const struct pel_radar_set *set = &seen.view->radar;
    const struct pel_radar_screen screen = {
        .gain = set->gain,
        .stc = set->stc,
        .ftc = set->ftc,
        .up_rad = set->north_up ? 0 : heading,
        .heading_rad = seen.view->entity >= 0 ? heading : NAN,
        .rings = set->rings ? 6 : 0,
    };
    bool stop = false;
    for (uint32_t row = 0; row < height && !stop; row += ROWS) {
        uint32_t rows = height - row < ROWS ? height - row : ROWS;
        pel_radar_show(&seen.radar, &screen, time_s, scan, width, height, row,
                       rows, rgba);
        stop = cancel && atomic_load(cancel);
    }
    pel_radar_scan_destroy(scan);
    return stop ? PEL_ERR_CONFLICT : PEL_OK;
}

enum pel_err pel_radar_view_draw(struct pel_job_draw *part,
                                 const atomic_bool *cancel)
{
    struct pel_job *job = part->job;
    const struct pel_camera *c = &job->draws[part - job->parts].camera;
    enum pel_err err = PEL_OK;
    pthread_mutex_lock(&lock);
    if (!part->picture) {
        size_t bytes = (size_t)c->width * c->height * 4;
        struct pel_picture *p = calloc(1, sizeof *p + bytes);
        uint8_t *rgba = p ? (uint8_t *)(p + 1) : NULL;
        int64_t begun_ns = pel_now_ns();
        err = p ? pel_radar_view_show(job->snapshot, part->view,
                                      job->environment.time_s, c->width,
                                      c->height, cancel, rgba)
                : PEL_ERR_NO_MEMORY;
        if (err == PEL_OK) {
            p->width = c->width;
            p->height = c->height;
            p->rgba = rgba;
            p->drawn_ns = pel_now_ns();
            p->render_ms = (double)(p->drawn_ns - begun_ns) * 1e-6;
            part->picture = p;
        } else {
            free(p);
        }
    }
    pthread_mutex_unlock(&lock);
    return err;
}

void pel_radar_view_release(struct pel_job_draw *part)
{
    free(part->picture);
    part->picture = NULL;
}
