/* A file of moving pictures made from JPEGs. One thread. */
#pragma once

#include <stddef.h>
#include <stdint.h>

struct clip;

/* Opens `path` by its ending: .mjpeg (bare JPEGs), .mkv (Motion-JPEG), .mp4
 * (H.264 by GStreamer's x264enc or openh264enc). NULL: *why (g_free) says
 * why, with the package that is missing if one is. */
struct clip *clip_open(const char *path, uint32_t width, uint32_t height,
                       double fps, char **why);

/* Adds one JPEG shown from time_s on. 0, or -1 and *why. */
int clip_add(struct clip *clip, const uint8_t *jpeg, size_t size, double time_s,
             char **why);

/* Ends the file and frees; 0, or -1 and *why. */
int clip_close(struct clip *clip, char **why);
