#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "frames/exr_notes.h"
#include "frames/job.h"

#define MAX_ATTRIBUTES (32 + PEL_EXR_NOTES)

/* Attributes are a function of what is drawn (never the wall clock or the
 * frame's number), so that the same state, time and seed give the same bytes.
 *
 * Of the standard's: software, comments, capDate and utcOffset (simulated UTC),
 * longitude, latitude [deg] and altitude [m] of the camera, worldToCamera and
 * worldToNDC (world: metres east, north, up of the scene's origin). Ours:
 *   pelagos.view          name of the view
 *   pelagos.time          simulated time [s]
 *   pelagos.revision      revision of the state
 *   pelagos.seed          seed of the waves, as text (32 bits unsigned)
 *   pelagos.exposure      EV100 of the 8-bit pictures of this view
 *   pelagos.sunAzimuth    [deg] true, pelagos.sunElevation [deg]
 *   pelagos.windSpeed     [m/s] at 10 m, pelagos.windDirection [deg] from
 *   pelagos.visibility    [m]
 *   pelagos.originLatitude, pelagos.originLongitude [deg]
 *   pelagos.positionEast, pelagos.positionNorth [m] to be added to the layer
 *                         position, multiples of 131072: 0 near the origin
 *   pelagos.radiance      unit of R, G, B and their wavelengths
 *   pelagos.device        GL renderer and version
 * and what frames/exr_notes.h lists. */
struct attributes {
    struct pel_exr_attribute list[MAX_ATTRIBUTES];
    size_t count;
    char date[32], seed[16];
    float world_to_camera[16], world_to_ndc[16];
    struct pel_exr_notes notes;
};

static void add_text(struct attributes *a, const char *name, const char *text)
{
    a->list[a->count++] = (struct pel_exr_attribute){ .name = name,
                                                      .type = PEL_EXR_STRING,
                                                      .string = text };
}

static void add_number(struct attributes *a, const char *name, double number)
{
    a->list[a->count++] = (struct pel_exr_attribute){ .name = name,
                                                      .type = PEL_EXR_DOUBLE,
                                                      .number = number };
}

static void add_float(struct attributes *a, const char *name, double number)
{
    a->list[a->count++] = (struct pel_exr_attribute){ .name = name,
                                                      .type = PEL_EXR_FLOAT,
                                                      .number = number };
}

static void add_matrix(struct attributes *a, const char *name, const float *m)
{
    a->list[a->count++] = (struct pel_exr_attribute){ .name = name,
                                                      .type = PEL_EXR_MATRIX,
                                                      .matrix = m };
}

/* True, in a local frame that is turned. */
static double bearing_deg(double east, double north, double turned_rad)
{
    double degrees =
        remainder(atan2(east, north) - turned_rad, 2 * PEL_PI) / PEL_DEG;
    return degrees < 0 ? degrees + 360 : degrees;
}

static void set_column(float *m, int column, struct pel_vec3 axis,
                       struct pel_vec3 eye)
{
    m[column] = (float)axis.x;
    m[4 + column] = (float)axis.y;
    m[8 + column] = (float)axis.z;
    m[12 + column] = (float)-pel_vec3_dot(axis, eye);
}

/* Row vectors, left-handed camera space with z along the line of sight; NDC
 * runs from (0, 0), upper left, to (1, 1): the standard's definitions. */
static void add_matrices(struct attributes *a, const struct pel_camera *c)
{
    const struct pel_mat3 *axes = &c->world_from_camera;
    struct pel_vec3 eye = { c->east_m, c->north_m, c->altitude_m };
    struct pel_vec3 ahead = pel_vec3_scale(axes->z, -1);
    double width = c->tan_right - c->tan_left;
    double height = c->tan_top - c->tan_bottom;
    /* x_ndc = (x/z − l)/(r − l), y_ndc = (t − y/z)/(t − b), as w = z. */
    struct pel_vec3 across = pel_vec3_scale(
        pel_vec3_add(axes->x, pel_vec3_scale(ahead, -c->tan_left)), 1 / width);
    struct pel_vec3 down =
        pel_vec3_scale(pel_vec3_add(pel_vec3_scale(ahead, c->tan_top),
                                    pel_vec3_scale(axes->y, -1)),
                       1 / height);
    set_column(a->world_to_camera, 0, axes->x, eye);
    set_column(a->world_to_camera, 1, axes->y, eye);
    set_column(a->world_to_camera, 2, ahead, eye);
    a->world_to_camera[15] = 1;
    set_column(a->world_to_ndc, 0, across, eye);
    set_column(a->world_to_ndc, 1, down, eye);
    a->world_to_ndc[14] = 1; /* z_ndc = 1 / distance */
    set_column(a->world_to_ndc, 3, ahead, eye);
    add_matrix(a, "worldToCamera", a->world_to_camera);
    add_matrix(a, "worldToNDC", a->world_to_ndc);
}

static void add_place_and_date(struct attributes *a, const struct pel_job *job,
                               const struct pel_camera *camera)
{
    const struct pel_snapshot *s = job->snapshot;
    double origin_lat = s->origin_latitude_rad / PEL_DEG;
    double origin_lon = s->origin_longitude_rad / PEL_DEG;
    double latitude, longitude;
    pel_geo_from_local(origin_lat, origin_lon, camera->east_m, camera->north_m,
                       &latitude, &longitude);
    add_float(a, "latitude", latitude);
    add_float(a, "longitude", longitude);
    add_float(a, "altitude", camera->altitude_m);
    add_number(a, "pelagos.originLatitude", origin_lat);
    add_number(a, "pelagos.originLongitude", origin_lon);
    time_t seconds = (time_t)floor(s->epoch_unix_s + job->environment.time_s);
    struct tm utc;
    if (gmtime_r(&seconds, &utc)) {
        strftime(a->date, sizeof a->date, "%Y:%m:%d %H:%M:%S", &utc);
        add_text(a, "capDate", a->date);
        add_float(a, "utcOffset", 0);
    }
}

static void list_attributes(struct attributes *a, const struct pel_output *o,
                            const char *device)
{
    const struct pel_job *job = o->job;
    const struct pel_job_draw *part = &job->parts[o->draw];
    const struct pel_environment *env = pel_job_environment(job, o->draw);
    const struct pel_camera *camera = &job->draws[o->draw].camera;
    double turned =
        part->place > 0 ? job->places[part->place - 1].place.turned_rad : 0;
    snprintf(a->seed, sizeof a->seed, "%u", (unsigned)env->sea->desc.seed);
    add_text(a, "software", "pelagosd " PEL_VERSION);
    add_text(a, "pelagos.view", job->snapshot->views[part->view].name);
    add_number(a, "pelagos.time", env->time_s);
    add_number(a, "pelagos.revision", (double)job->snapshot->revision);
    add_text(a, "pelagos.seed", a->seed);
    add_number(a, "pelagos.exposure", part->picture->exposure_ev);
    add_number(a, "pelagos.sunAzimuth",
               bearing_deg(env->lights[PEL_LIGHT_SUN].direction.x,
                           env->lights[PEL_LIGHT_SUN].direction.y, turned));
    add_number(a, "pelagos.sunElevation",
               asin(pel_clamp(env->lights[PEL_LIGHT_SUN].direction.z, -1, 1)) /
                   PEL_DEG);
    add_number(a, "pelagos.windSpeed", env->wind_mps);
    add_number(
        a, "pelagos.windDirection",
        bearing_deg(-cos(env->wind_to_rad), -sin(env->wind_to_rad), turned));
    add_number(a, "pelagos.visibility", env->visibility_m);
    add_text(a, "pelagos.radiance",
             "R 680 nm, G 550 nm, B 440 nm, W m^-2 sr^-1 nm^-1");
    add_text(a, "pelagos.device", device);
    add_place_and_date(a, job, camera);
    add_matrices(a, camera);
    if (o->layers & PEL_LAYER_POSITION) {
        double east, north;
        pel_picture_position_origin(camera, &east, &north);
        add_number(a, "pelagos.positionEast", east);
        add_number(a, "pelagos.positionNorth", north);
    }
    pel_exr_notes_list(o, &a->notes);
    for (size_t i = 0; i < a->notes.count; i++) {
        a->list[a->count++] = a->notes.list[i];
    }
}

enum pel_err pel_picture_encode_layers(const struct pel_output *output,
                                       const char *device, pel_encode *encode,
                                       struct pel_bytes *out)
{
    const struct pel_picture *p = output->job->parts[output->draw].picture;
    const struct pel_camera *c = &output->job->draws[output->draw].camera;
    struct attributes attributes;
    attributes.count = 0;
    memset(attributes.world_to_camera, 0, sizeof attributes.world_to_camera);
    memset(attributes.world_to_ndc, 0, sizeof attributes.world_to_ndc);
    struct pel_exr_layer layers[PEL_LAYERS];
    size_t count = 0;
    float *position = NULL;
    if (output->layers & PEL_LAYER_POSITION) {
        position = malloc((size_t)p->width * p->height * 3 * sizeof *position);
        if (!position) {
            return PEL_ERR_NO_MEMORY;
        }
        pel_picture_position(
            p, c, pel_job_environment(output->job, output->draw), position);
    }
    /* A night's radiance is less than a half can be. */
    bool dark = pel_job_environment(output->job, output->draw)
                    ->lights[PEL_LIGHT_SUN]
                    .direction.z < sin(-4.0 * PEL_DEG);
    for (int i = 0; i < PEL_LAYERS; i++) {
        const struct pel_layer_info *l = &pel_layer_table[i];
        if (output->layers & l->bit) {
            /* Radiance is what viewers show: the layer without a name. */
            layers[count++] = (struct pel_exr_layer){
                .name = l->bit == PEL_LAYER_RADIANCE ? NULL : l->name,
                .channels = l->channels,
                .pixels = l->bit == PEL_LAYER_POSITION ? position : p->layer[i],
                .stride = pel_layer_stride(l),
                .full_float =
                    l->full_float || (dark && l->bit & pel_layers_of_light()),
            };
        }
    }
    if (output->layers == (unsigned)PEL_LAYER_DEPTH) {
        /* Where it is alone it is the picture to those who look for one; by Z
         * without a layer's name ffmpeg finds nothing, and OpenCV zeros. */
        layers[count] = layers[0];
        layers[count].name = NULL;
        layers[count++].channels = "Y";
    }
    list_attributes(&attributes, output, device);
    double width = c->tan_right - c->tan_left;
    double height = c->tan_top - c->tan_bottom;
    const struct pel_encode_input image = {
        .width = p->width,
        .height = p->height,
        .float_samples = output->float_samples,
        .layers = layers,
        .layer_count = count,
        .attributes = attributes.list,
        .attribute_count = attributes.count,
        .window_center = { (float)((c->tan_left + c->tan_right) / 2),
                           (float)((c->tan_bottom + c->tan_top) / 2) },
        .window_width = (float)width,
        .pixel_aspect = (float)((width / p->width) / (height / p->height)),
        .cancel = &output->cancel,
    };
    enum pel_err err = encode(&image, out);
    free(position);
    return err;
}
