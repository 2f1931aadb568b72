/* What cameras write into their files: EXIF 2.32 (a TIFF block) and XMP, of a
 * picture that is kept. Plain bytes, a function of what is given; any thread.
 */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct pel_photo {
    const char *software, *view;        /* the camera's name; UTF-8 */
    double unix_s;                      /* simulated UTC */
    double time_s;                      /* simulated time */
    double latitude_deg, longitude_deg; /* WGS 84 */
    double altitude_m;                  /* above altitude 0 */
    /* Of the line of sight: clockwise of true north 0..360, up −90..90; right
     * side down −180..180. */
    double heading_deg, pitch_deg, roll_deg;
    double horizontal_fov_deg, vertical_fov_deg;
    double exposure_ev; /* EV100 */
    bool in_ground;     /* the camera is inside the ground */
    uint32_t width, height;
};

#define PEL_PHOTO_EXIF_MOST 3200
#define PEL_PHOTO_XMP_MOST 3072

/* Sizes 0: there is none. */
struct pel_photo_blocks {
    unsigned char exif[PEL_PHOTO_EXIF_MOST]; /* from "II*" on */
    size_t exif_size;
    char xmp[PEL_PHOTO_XMP_MOST];
    size_t xmp_size;
};

/* Always makes both. A time before 1970 or after 9999 is left out, and so is
 * a number that is not finite. */
void pel_photo_write(const struct pel_photo *photo,
                     struct pel_photo_blocks *out);
