/* What files of pictures say of the camera that took them. Any thread. */
#pragma once

#include "encode/photo.h"
#include "frames/job.h"

/* Of the axes of a draw's camera: line of sight clockwise from true north
 * 0..360 and up, right side down, degrees. */
void pel_camera_attitude(const struct pel_job *job, size_t draw,
                         double *heading_deg, double *pitch_deg,
                         double *roll_deg);

/* Whether a draw's camera is below the seabed's surface: inside the ground. */
bool pel_camera_in_ground(const struct pel_job *job, size_t draw);

/* Degrees between the picture's left and right (bottom and top) edges. */
double pel_camera_field(double tan_low, double tan_high);

/* The camera of draw `output->draw`, a function of what is drawn; its texts are
 * the snapshot's. */
void pel_picture_photo(const struct pel_output *output, struct pel_photo *out);
