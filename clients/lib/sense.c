/* What an uncrewed vessel senses: the sea under its hull, the distance of each
 * pixel of a view, and which entity it shows.
 *
 *   cc sense.c $(pkg-config --cflags --libs pelagos OpenEXR) -lOpenEXRCore -o
 * sense
 *   ./sense bridge [ADDRESS [QUERIES]]
 *
 * ADDRESS as pel_client_connect has it, "" for the usual one. With QUERIES it
 * also asks so many times for the water at the hull, and says how many a second
 * are answered: what a simulator has for a hull that floats on this sea. */
#include <math.h>
#include <openexr.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "pelagos.h"

enum { ENTITIES = 65536 };

/* Corners and middle of a hull of 6 m by 3 m at the origin, its bow north. */
static const double hull[][2] = {
    { 0, 3 }, { 0, -3 }, { 1.5, 0 }, { -1.5, 0 }, { 0, 0 }
};
enum { HULL = sizeof hull / sizeof hull[0] };

struct layers {
    int width, height;
    float *depth; /* metres along the ray; infinite: sky */
    float *ids;   /* the entity's number plus one; 0: none */
};

/* --- OpenEXR in memory -----------------------------------------------------
 */

static int64_t read_bytes(exr_const_context_t context, void *user, void *out,
                          uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t error)
{
    const ProtobufCBinaryData *file = user;
    (void)context;
    (void)error;
    if (offset > file->len) {
        return -1;
    }
    uint64_t left = file->len - offset, count = size < left ? size : left;
    memcpy(out, file->data + offset, count);
    return (int64_t)count;
}

static int64_t size_of(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((const ProtobufCBinaryData *)user)->len;
}

/* Where the channels of one chunk go; what is not wanted goes nowhere. */
static void aim(exr_decode_pipeline_t *pipe, const struct layers *l, int y)
{
    const size_t at = (size_t)y * (size_t)l->width;
    for (int i = 0; i < pipe->channel_count; i++) {
        exr_coding_channel_info_t *c = &pipe->channels[i];
        void *to = NULL;
        if (strcmp(c->channel_name, "depth.Z") == 0) {
            to = l->depth + at;
        } else if (strcmp(c->channel_name, "id.I") == 0) {
            to = l->ids + at;
        }
        c->decode_to_ptr = to;
        c->user_bytes_per_element = 4;
        c->user_data_type = c->data_type;
        c->user_pixel_stride = 4;
        c->user_line_stride = 4 * l->width;
    }
}

static bool decode(exr_context_t context, struct layers *l)
{
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t lines = 0;
    bool good = exr_get_scanlines_per_chunk(context, 0, &lines) == 0;
    for (int y = 0; good && y < l->height; y += lines) {
        exr_chunk_info_t chunk;
        good = exr_read_scanline_chunk_info(context, 0, y, &chunk) == 0 &&
               (y == 0 ? exr_decoding_initialize(context, 0, &chunk, &pipe)
                       : exr_decoding_update(context, 0, &chunk, &pipe)) == 0;
        if (good) {
            aim(&pipe, l, y);
            good = (y > 0 || exr_decoding_choose_default_routines(
                                 context, 0, &pipe) == 0) &&
                   exr_decoding_run(context, 0, &pipe) == 0;
        }
    }
    exr_decoding_destroy(context, &pipe);
    return good;
}

/* Reads the two layers; they are to be freed also where it fails. */
static bool read_layers(ProtobufCBinaryData *file, struct layers *out)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t context;
    exr_attr_box2i_t window;
    init.user_data = file;
    init.read_fn = read_bytes;
    init.size_fn = size_of;
    if (exr_start_read(&context, "frame", &init) != 0) {
        return false;
    }
    bool good = exr_get_data_window(context, 0, &window) == 0;
    if (good) {
        out->width = window.max.x + 1;
        out->height = window.max.y + 1;
        size_t pixels = (size_t)out->width * (size_t)out->height;
        out->depth = calloc(pixels, sizeof *out->depth);
        out->ids = calloc(pixels, sizeof *out->ids);
        good = out->depth && out->ids && decode(context, out);
    }
    exr_finish(&context);
    return good;
}

/* --- what is sensed ----------------------------------------------------------
 */

static bool print_water(struct pel_client *client,
                        struct pel_client_error *error)
{
    Pelagos__Surface *surface = NULL;
    if (pel_client_surface(client, hull, HULL, NULL, &surface, error)) {
        return false;
    }
    printf("the sea at %.3f s:\n", surface->time);
    for (size_t i = 0; i < surface->n_points; i++) {
        const Pelagos__SurfacePoint *p = surface->points[i];
        printf("  %5.1f m east, %5.1f m north: %6.3f m, rising %6.3f m/s\n",
               hull[i][0], hull[i][1], p->height, p->velocity->up);
    }
    pelagos__surface__free_unpacked(surface, NULL);
    return true;
}

static void print_entities(const struct layers *l)
{
    static float nearest[ENTITIES + 1];
    static unsigned pixels[ENTITIES + 1];
    unsigned sea = 0, sky = 0;
    for (int i = 0; i < l->width * l->height; i++) {
        unsigned id = (unsigned)l->ids[i];
        if (id == 0 || id > ENTITIES) {
            *(isinf(l->depth[i]) ? &sky : &sea) += 1;
        } else if (pixels[id]++ == 0 || l->depth[i] < nearest[id]) {
            nearest[id] = l->depth[i];
        }
    }
    printf("%d x %d pixels: %u of sea, %u of sky\n", l->width, l->height, sea,
           sky);
    for (unsigned id = 1; id <= ENTITIES; id++) {
        if (pixels[id] > 0) {
            printf("  entity %u: %u pixels, %.1f m away\n", id - 1, pixels[id],
                   (double)nearest[id]);
        }
    }
}

static bool print_view(struct pel_client *client, char *view,
                       struct pel_client_error *error)
{
    char *names[] = { (char[]){ "depth" }, (char[]){ "id" } };
    Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
    Pelagos__Frame *frame = NULL;
    struct layers layers = { 0 };
    request.view = view;
    request.has_format = true;
    request.format = PELAGOS__FRAME_FORMAT__EXR;
    request.n_layers = 2;
    request.layers = names;
    if (pel_client_frame(client, &request, &frame, error)) {
        return false;
    }
    bool good = read_layers(&frame->data, &layers);
    if (good) {
        printf("%s at %.3f s, ", frame->view, frame->time);
        print_entities(&layers);
    } else {
        snprintf(error->message, sizeof error->message, "the frame is damaged");
    }
    free(layers.depth);
    free(layers.ids);
    pelagos__frame__free_unpacked(frame, NULL);
    return good;
}

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* As a simulator of 100 Hz: each time a moment of its own. */
static bool time_queries(struct pel_client *client, int count,
                         struct pel_client_error *error)
{
    double begun = now_s(), longest = 0;
    for (int i = 0; i < count; i++) {
        Pelagos__Surface *surface = NULL;
        double time_s = 100 + 0.01 * i, asked = now_s();
        struct pel_client_sea sea = { .time_s = &time_s };
        if (pel_client_surface(client, hull, HULL, &sea, &surface, error)) {
            return false;
        }
        pelagos__surface__free_unpacked(surface, NULL);
        longest = fmax(longest, now_s() - asked);
    }
    printf("%d queries of %d points, each of a time of its own: %.0f a second, "
           "the longest %.1f ms\n",
           count, HULL, count / (now_s() - begun), 1e3 * longest);
    return true;
}

int main(int argc, char **argv)
{
    const char *address = argc > 2 && argv[2][0] ? argv[2] : NULL;
    struct pel_client_error error;
    struct pel_client *client = NULL;
    if (argc < 2 || argc > 4) {
        fprintf(stderr, "usage: sense VIEW [ADDRESS [QUERIES]]\n");
        return 2;
    }
    bool good = !pel_client_connect(address, 60000, &client, &error) &&
                print_water(client, &error) &&
                print_view(client, argv[1], &error) &&
                (argc < 4 || time_queries(client, atoi(argv[3]), &error));
    if (!good) {
        fprintf(stderr, "%s\n", error.message);
    }
    pel_client_close(client);
    return good ? 0 : 1;
}
