/* Saves a live stream to a file of Motion-JPEG, which players open as it is:
 *
 *   cc save_live.c $(pkg-config --cflags --libs pelagos) -o save_live
 *   ./save_live VIEW clip.mjpeg [SECONDS [http://HOST:PORT]]
 *   ffplay clip.mjpeg */
#include <stdio.h>
#include <stdlib.h>

#include "pelagos.h"

/* Frames of `seconds` of simulated time; -1 after an error. */
static long save(struct pel_live *live, FILE *file, double seconds)
{
    struct pel_client_error error;
    struct pel_live_frame frame;
    double first_s = 0.0, last_s = 0.0;
    long count = 0;
    while (count == 0 || last_s - first_s < seconds) {
        if (pel_live_next(live, 10000, &frame, &error)) {
            fprintf(stderr, "%s\n", error.message);
            return -1;
        }
        if (fwrite(frame.data, 1, frame.size, file) != frame.size) {
            perror("write");
            return -1;
        }
        first_s = count++ == 0 ? frame.time_s : first_s;
        last_s = frame.time_s;
    }
    printf("%ld frames, %.3f s to %.3f s, %llu dropped\n", count, first_s,
           last_s, (unsigned long long)frame.dropped);
    return count;
}

int main(int argc, char **argv)
{
    if (argc < 3) {
        fprintf(stderr, "usage: %s VIEW FILE [SECONDS [URL]]\n", argv[0]);
        return 2;
    }
    double seconds = argc > 3 ? strtod(argv[3], NULL) : 5.0;
    struct pel_client_error error;
    struct pel_live *live = NULL;
    if (pel_live_open(argc > 4 ? argv[4] : NULL, argv[1], 0, 0, 30000, &live,
                      &error)) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    FILE *file = fopen(argv[2], "wb");
    if (!file) {
        perror(argv[2]);
        pel_live_close(live);
        return 1;
    }
    long count = save(live, file, seconds);
    if (fclose(file) != 0) {
        perror(argv[2]);
        count = -1;
    }
    pel_live_close(live);
    return count < 0;
}
