/* Saves one frame of the first view:
 *
 *   cc example.c $(pkg-config --cflags --libs pelagos) -o example
 *   ./example frame.jpg [tcp:HOST:PORT | unix:PATH] */
#include <stdio.h>

#include "pelagos.h"

static int save(const Pelagos__Frame *frame, const char *path)
{
    FILE *file = fopen(path, "wb");
    if (!file) {
        perror(path);
        return 1;
    }
    size_t written = fwrite(frame->data.data, 1, frame->data.len, file);
    if (fclose(file) != 0 || written != frame->data.len) {
        perror(path);
        return 1;
    }
    printf("%s: %s at %.3f s, %u x %u, drawn in %.1f ms\n", path, frame->view,
           frame->time, frame->width, frame->height, frame->render_ms);
    return 0;
}

int main(int argc, char **argv)
{
    const char *path = argc > 1 ? argv[1] : "frame.jpg";
    struct pel_client_error error;
    struct pel_client *client = NULL;
    Pelagos__State *state = NULL;
    Pelagos__Frame *frame = NULL;
    int status = 1;

    if (pel_client_connect(argc > 2 ? argv[2] : NULL, 30000, &client, &error) ||
        pel_client_get(client, &state, &error)) {
        fprintf(stderr, "%s\n", error.message);
    } else if (state->n_views == 0) {
        fprintf(stderr, "the scene has no view\n");
    } else {
        Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
        request.view = state->views[0]->name;
        if (pel_client_frame(client, &request, &frame, &error)) {
            fprintf(stderr, "%s\n", error.message);
        } else {
            status = save(frame, path);
        }
    }
    if (frame) {
        pelagos__frame__free_unpacked(frame, NULL);
    }
    if (state) {
        pelagos__state__free_unpacked(state, NULL);
    }
    pel_client_close(client);
    return status;
}
