#include "net/rtspgate.h"

#define LOOK_MS 100 /* whether it still waits for its turn */

void pel_rtsp_gate_begin(struct pel_rtsp_gate *gate)
{
    g_mutex_init(&gate->lock);
    g_cond_init(&gate->left);
}

void pel_rtsp_gate_end(struct pel_rtsp_gate *gate)
{
    g_mutex_clear(&gate->lock);
    g_cond_clear(&gate->left);
}

void pel_rtsp_gate_pass(struct pel_rtsp_gate *gate,
                        const _Atomic int64_t *since_ns, bool *at_work)
{
    if (*at_work) {
        return;
    }
    g_mutex_lock(&gate->lock);
    while (gate->at_work >= PEL_RTSP_AT_WORK &&
           atomic_load(since_ns) != INT64_MAX) {
        g_cond_wait_until(&gate->left, &gate->lock,
                          g_get_monotonic_time() +
                              LOOK_MS * G_TIME_SPAN_MILLISECOND);
    }
    gate->at_work++;
    *at_work = true;
    g_mutex_unlock(&gate->lock);
}

void pel_rtsp_gate_leave(struct pel_rtsp_gate *gate, bool *at_work)
{
    if (*at_work) {
        g_mutex_lock(&gate->lock);
        gate->at_work--;
        *at_work = false;
        g_cond_signal(&gate->left);
        g_mutex_unlock(&gate->lock);
    }
}
