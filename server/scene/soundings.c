#include "scene/soundings.h"

#include <glib.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "fault.h"
#include "scene/geodesy.h"
#include "scene/scene_parts.h"

#define MAX_WAITING 128

/* In cells larger than the field's the shallowest node counts. */
static void take_nodes(const struct pel_seabed *bed,
                       const struct pel_soundings_raster *r, float *depth_m)
{
    const double s = sin(r->up_rad), c = cos(r->up_rad);
    for (int j = 0; j < bed->rows; j++) {
        const double north = bed->south_m + j * bed->spacing_m - r->north_m;
        for (int i = 0; i < bed->columns; i++) {
            const size_t node = (size_t)j * (size_t)bed->columns + (size_t)i;
            const double east = bed->west_m + i * bed->spacing_m - r->east_m;
            const double x =
                floor((east * c - north * s) / r->spacing_m + 0.5 * r->columns);
            const double y =
                floor(0.5 * r->rows - (east * s + north * c) / r->spacing_m);
            if (x >= 0 && y >= 0 && x < r->columns && y < r->rows &&
                bed->known[node]) {
                float *cell =
                    &depth_m[(size_t)y * (size_t)r->columns + (size_t)x];
                *cell = fminf(*cell, -bed->height_m[node]);
            }
        }
    }
}

void pel_soundings_fill(const struct pel_seabed *bed,
                        const struct pel_soundings_raster *r, float *depth_m)
{
    const double s = sin(r->up_rad), c = cos(r->up_rad);
    for (int j = 0; j < r->rows; j++) {
        const double up = (0.5 * r->rows - j - 0.5) * r->spacing_m;
        for (int i = 0; i < r->columns; i++) {
            const double right = (i + 0.5 - 0.5 * r->columns) * r->spacing_m;
            double height;
            bool known =
                pel_seabed_height(bed, r->east_m + right * c + up * s,
                                  r->north_m - right * s + up * c, &height);
            *depth_m++ = known ? (float)-height : NAN;
        }
    }
    if (r->spacing_m > bed->spacing_m) {
        take_nodes(bed, r, depth_m - (size_t)r->rows * (size_t)r->columns);
    }
}

/* --- on a thread ---------------------------------------------------------- */

struct asked {
    struct pel_task task;
    const struct pel_seabed *bed;
    struct pel_soundings_raster raster;
    float *depth_m; /* NULL: no memory */
    pel_soundings_done done;
    void *user;
};

static size_t count_of(const struct asked *a)
{
    return (size_t)a->raster.columns * (size_t)a->raster.rows;
}

static void work(struct pel_task *task)
{
    struct asked *a = (struct asked *)task;
    a->depth_m = malloc(count_of(a) * sizeof *a->depth_m);
    if (!a->depth_m) {
        return;
    }
    pel_soundings_fill(a->bed, &a->raster, a->depth_m);
    for (size_t i = 0; i < count_of(a); i++) {
        guint32 bits;
        memcpy(&bits, &a->depth_m[i], sizeof bits);
        bits = GUINT32_TO_LE(bits);
        memcpy(&a->depth_m[i], &bits, sizeof bits);
    }
}

static void tell(struct pel_task *task, bool dropped)
{
    struct asked *a = (struct asked *)task;
    struct pel_fault fault = { 0 };
    enum pel_err err = PEL_OK;
    if (dropped) {
        err = pel_fault_set(&fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    } else if (!a->depth_m) {
        err = pel_fault_set(&fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    if (err) {
        free(a->depth_m);
        a->depth_m = NULL;
    }
    a->done(a->user, err, &fault, a->depth_m, err ? 0 : count_of(a));
    pel_seabed_unref(a->bed);
    g_free(a);
}

/* The raster of a tested query in the scene's local frame. */
static struct pel_soundings_raster raster_of(const Pelagos__State *state,
                                             const Pelagos__SoundingsQuery *q)
{
    const Pelagos__Origin *o = state->origin;
    struct pel_soundings_raster r = { .columns = (int)q->columns,
                                      .rows = (int)q->rows,
                                      .spacing_m = q->spacing };
    double latitude = q->has_latitude ? q->latitude : o->latitude;
    double longitude = q->has_longitude ? q->longitude : o->longitude;
    pel_geo_to_local(o->latitude, o->longitude, latitude, longitude, &r.east_m,
                     &r.north_m);
    r.up_rad =
        q->turn * PEL_DEG +
        pel_geo_convergence(o->latitude, o->longitude, latitude, longitude);
    return r;
}

enum pel_err pel_scene_ask_soundings(struct pel_scene *scene,
                                     const Pelagos__SoundingsQuery *query,
                                     pel_soundings_done done, void *user,
                                     struct pel_fault *fault)
{
    if (!scene->has.ground.bed) {
        return pel_fault_refuse(PEL_ERR_CONFLICT, "seabed.file", NULL,
                                "names no file, so that there is no bottom to "
                                "sound: set it to one of --bathymetry",
                                fault);
    }
    if (pel_worker_count(scene->numbers) >= MAX_WAITING) {
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "%d questions of numbers wait already",
                             MAX_WAITING);
    }
    struct asked *a = g_new0(struct asked, 1);
    a->task = (struct pel_task){ .work = work, .done = tell };
    a->bed = pel_seabed_ref(scene->has.ground.bed);
    a->raster = raster_of(pel_scene_state(scene), query);
    a->done = done;
    a->user = user;
    pel_worker_push(scene->numbers, &a->task);
    return PEL_OK;
}
