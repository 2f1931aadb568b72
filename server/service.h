/* The daemon as a service: limits of the process, readiness and watchdog
 * towards systemd, the first frame. Main thread. */
#pragma once

#include <stdint.h>

#include "frames/frames.h"
#include "scene/scene.h"

/* Raises the soft limit of descriptors to what is allowed (at most 8192) and
 * warns of limits that this program cannot live with. IO: so few are left that
 * it could not serve anybody. */
PEL_CHECK enum pel_err pel_service_limits(struct pel_fault *fault);

/* Draws a small picture of the first view, so that shaders are compiled
 * before anybody waits for them, and calls `ready` when it is done (or there
 * is none). started_ns: CLOCK_MONOTONIC at the start, for the log. */
void pel_service_warm_up(struct pel_frames *frames, struct pel_scene *scene,
                         int64_t started_ns, void (*ready)(void *user),
                         void *user);

/* Says READY=1; then feeds the watchdog, as long as frames are delivered when
 * frames are due, and reports the status every 10 s. */
struct pel_service;
struct pel_service *pel_service_ready(struct pel_frames *frames);
void pel_service_stopping(struct pel_service *service); /* NULL allowed */
