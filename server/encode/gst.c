#include "encode/gst.h"

#include <pthread.h>
#include <string.h>

#include <gst/gst.h>

static pthread_once_t once = PTHREAD_ONCE_INIT;
static char message[160]; /* "": it runs; written once */

static void start(void)
{
    GError *error = NULL;
    if (!gst_init_check(NULL, NULL, &error)) {
        g_strlcpy(message, error ? error->message : "no reason given",
                  sizeof message);
        g_clear_error(&error);
    }
}

enum pel_err pel_gst_start(struct pel_fault *fault)
{
    pthread_once(&once, start);
    if (message[0]) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "GStreamer does not start: %s", message);
    }
    return PEL_OK;
}
