/* Media of RTSP are made and ended by few clients at a time of those who may
 * only watch: it takes the processors, which others need. Each waits on a
 * thread of its own. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include <glib.h>

#define PEL_RTSP_AT_WORK 6

struct pel_rtsp_gate {
    GMutex lock; /* protects at_work */
    GCond left;
    int at_work;
};

void pel_rtsp_gate_begin(struct pel_rtsp_gate *gate);
void pel_rtsp_gate_end(struct pel_rtsp_gate *gate);

/* Waits until the work may begin, or *since_ns is INT64_MAX: the client is sent
 * away. *at_work: it has begun, until pel_rtsp_gate_leave. A client's thread.
 */
void pel_rtsp_gate_pass(struct pel_rtsp_gate *gate,
                        const _Atomic int64_t *since_ns, bool *at_work);
void pel_rtsp_gate_leave(struct pel_rtsp_gate *gate, bool *at_work);
