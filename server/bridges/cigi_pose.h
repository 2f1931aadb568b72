/* Places and attitudes between CIGI and the scene's local frame. Pure
 * functions, any thread. Body axes are CIGI's: x forward, y right, z down. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/vec.h"
#include "scene/snapshot.h"

/* Columns: forward, right and down of a body in east, north, up. Heading
 * first (clockwise), then pitch (bow up), then roll (right side down). */
struct pel_mat3 pel_cigi_axes(double heading_rad, double pitch_rad,
                              double roll_rad);

/* The angles of such axes; heading −π..π. */
void pel_cigi_angles(const struct pel_mat3 *axes, double *heading_rad,
                     double *pitch_rad, double *roll_rad);

/* Index of entity `id` in the snapshot, or -1. */
int pel_cigi_find_entity(const struct pel_snapshot *s, uint32_t id);

/* Where entity `id` is at time_s; false: there is none. */
bool pel_cigi_entity_axes(const struct pel_snapshot *s, uint32_t id,
                          double time_s, struct pel_vec3 *at,
                          struct pel_mat3 *axes);

/* A place of a packet in the local frame: geodetic degrees and metres, or,
 * with `local`, metres along the axes of `entity`. False: no such entity. */
bool pel_cigi_place(const struct pel_snapshot *s, double time_s, bool local,
                    uint32_t entity, const double abc[3], struct pel_vec3 *out);

/* Degrees of a local place, and of a local heading there. */
void pel_cigi_geodetic(const struct pel_snapshot *s, struct pel_vec3 at,
                       double *latitude, double *longitude);
double pel_cigi_true_deg(const struct pel_snapshot *s, struct pel_vec3 at,
                         double heading_rad);

/* Degrees in 0..360 (360 excluded). */
double pel_cigi_wrap(double degrees);
