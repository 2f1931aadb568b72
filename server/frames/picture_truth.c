#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "frames/job.h"
#include "json.h"
#include "models/model.h"
#include "pelagos.pb-c.h"
#include "render/truth.h"
#include "scene/geodesy.h"

/* The messages of one entity; what they name is others'. */
struct seen {
    Pelagos__SeenEntity message;
    Pelagos__PixelBox visible, whole;
    Pelagos__SeenPoint points[10];
    Pelagos__SeenPoint *list[10];
};

/* Everything that the answer is put together from. */
struct work {
    struct pel_truth truth[PEL_MAX_ENTITIES];
    struct seen seen[PEL_MAX_ENTITIES];
    Pelagos__SeenEntity *list[PEL_MAX_ENTITIES];
};

#define SET(message, field, value)                                             \
    do {                                                                       \
        (message)->has_##field = true;                                         \
        (message)->field = (value);                                            \
    } while (0)

static double degrees(double rad)
{
    return pel_bearing_deg(rad / PEL_DEG, 2);
}

static void set_box(Pelagos__PixelBox *to, const struct pel_truth_box *from)
{
    pelagos__pixel_box__init(to);
    SET(to, x, from->left);
    SET(to, y, from->top);
    SET(to, width, from->right - from->left);
    SET(to, height, from->bottom - from->top);
}

static void set_point(Pelagos__SeenPoint *to,
                      const struct pel_truth_point *from)
{
    pelagos__seen_point__init(to);
    SET(to, east, from->world.x);
    SET(to, north, from->world.y);
    SET(to, up, from->world.z);
    SET(to, right, from->camera.x);
    SET(to, down, from->camera.y);
    SET(to, ahead, from->camera.z);
    if (from->before) {
        SET(to, x, from->x);
        SET(to, y, from->y);
    }
}

static void set_pose(Pelagos__SeenEntity *to, const struct pel_job *job,
                     uint32_t id)
{
    const struct pel_snapshot *s = job->snapshot;
    double lat0 = s->origin_latitude_rad / PEL_DEG;
    double lon0 = s->origin_longitude_rad / PEL_DEG;
    size_t i = 0;
    while (i < s->entity_count && s->entities[i].id != id) {
        i++;
    }
    if (i == s->entity_count) {
        return;
    }
    struct pel_entity_state e;
    double latitude, longitude;
    pel_snapshot_entity_in_wakes(s, i, job->environment.time_s, &e);
    pel_geo_from_local(lat0, lon0, e.east_m, e.north_m, &latitude, &longitude);
    double turned = pel_geo_convergence(lat0, lon0, latitude, longitude);
    SET(to, latitude, latitude);
    SET(to, longitude, longitude);
    SET(to, altitude, e.altitude_m);
    SET(to, heading, degrees(e.heading_rad - turned));
    SET(to, pitch, e.pitch_rad / PEL_DEG);
    SET(to, roll, e.roll_rad / PEL_DEG);
    SET(to, speed, e.speed_mps);
    SET(to, course, degrees(e.course_rad - turned));
}

static void set_model(Pelagos__SeenEntity *to, const struct pel_model *model)
{
    to->model = (char *)model->name;
    SET(to, class_, (Pelagos__ModelClass)model->class);
    SET(to, length, model->length_m);
    SET(to, beam, model->beam_m);
    SET(to, draught, model->draught_m);
}

static void set_pixels(struct seen *to, const struct pel_truth *t,
                       const struct pel_picture *p)
{
    Pelagos__SeenEntity *m = &to->message;
    SET(m, pixels, t->pixels);
    SET(m, whole_pixels, t->whole_pixels);
    if (t->pixels > 0) {
        set_box(&to->visible, &t->visible);
        m->visible = &to->visible;
    }
    if (t->whole.right >= t->whole.left) {
        set_box(&to->whole, &t->whole);
        m->whole = &to->whole;
        SET(m, truncated,
            t->whole.left < 0 || t->whole.top < 0 ||
                t->whole.right > p->width || t->whole.bottom > p->height);
    }
    if (t->whole_pixels > 0) {
        SET(m, hidden, 1.0 - (double)t->shown_pixels / t->whole_pixels);
    }
}

static void set_seen(struct seen *to, const struct pel_truth *t,
                     const struct pel_job *job, const struct pel_picture *p,
                     double turned_rad)
{
    Pelagos__SeenEntity *m = &to->message;
    pelagos__seen_entity__init(m);
    SET(m, id, t->object->id);
    set_model(m, t->object->model);
    set_pixels(to, t, p);
    for (int i = 0; i < 10; i++) {
        set_point(&to->points[i],
                  i < 8 ? &t->corners[i] : &t->waterline[i - 8]);
        to->list[i] = &to->points[i];
    }
    m->n_corners = 8;
    m->corners = to->list;
    m->n_waterline = 2;
    m->waterline = to->list + 8;
    SET(m, distance, t->distance_m);
    SET(m, bearing, degrees(t->bearing_rad - turned_rad));
    set_pose(m, job, t->object->id);
}

enum pel_err pel_picture_encode_truth(const struct pel_output *output,
                                      pel_encode *encode, struct pel_bytes *out)
{
    const struct pel_job *job = output->job;
    const struct pel_job_draw *part = &job->parts[output->draw];
    const struct pel_picture *p = part->picture;
    size_t count = 0;
    struct work *work = calloc(1, sizeof *work);
    enum pel_err err =
        work ? pel_truth_find(p, &job->draws[output->draw].camera,
                              pel_job_environment(job, output->draw),
                              work->truth, &count)
             : PEL_ERR_NO_MEMORY;
    if (err != PEL_OK) {
        free(work);
        return err;
    }
    double turned_rad = pel_job_turned(job, output->draw);
    for (size_t i = 0; i < count; i++) {
        set_seen(&work->seen[i], &work->truth[i], job, p, turned_rad);
        work->list[i] = &work->seen[i].message;
    }
    Pelagos__FrameTruth truth = PELAGOS__FRAME_TRUTH__INIT;
    truth.view = (char *)job->snapshot->views[part->view].name;
    SET(&truth, time, job->environment.time_s);
    SET(&truth, revision, job->snapshot->revision);
    SET(&truth, width, p->width);
    SET(&truth, height, p->height);
    truth.n_entities = count;
    truth.entities = work->list;
    char *text = pel_json_from_message(&truth.base, false);
    const struct pel_encode_input input = { .text = text };
    err = text ? encode(&input, out) : PEL_ERR_NO_MEMORY;
    free(text);
    free(work);
    return err;
}
