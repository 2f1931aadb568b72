#include "net/rtspauth.h"

#include <string.h>

struct auth {
    GstRTSPAuth parent;
    struct pel_token *token;
};

static bool is_authorized(const struct auth *self, const GstRTSPContext *at)
{
    char *value = NULL, *second = NULL;
    return gst_rtsp_message_get_header(at->request, GST_RTSP_HDR_AUTHORIZATION,
                                       &value, 0) == GST_RTSP_OK &&
           gst_rtsp_message_get_header(at->request, GST_RTSP_HDR_AUTHORIZATION,
                                       &second, 1) != GST_RTSP_OK &&
           pel_token_authorizes(self->token, value) >= PEL_ROLE_WATCH;
}

static void ask(GstRTSPContext *at)
{
    gst_rtsp_message_init_response(
        at->response, GST_RTSP_STS_UNAUTHORIZED,
        gst_rtsp_status_as_text(GST_RTSP_STS_UNAUTHORIZED), at->request);
    gst_rtsp_message_add_header(at->response, GST_RTSP_HDR_WWW_AUTHENTICATE,
                                "Basic realm=\"pelagos\"");
    gst_rtsp_client_send_message(at->client, at->session, at->response);
}

static gboolean check(GstRTSPAuth *auth, GstRTSPContext *at, const gchar *what)
{
    const struct auth *self = (const struct auth *)auth;
    if (strcmp(what, GST_RTSP_AUTH_CHECK_CONNECT) == 0) {
        return TRUE;
    }
    if (strcmp(what, GST_RTSP_AUTH_CHECK_TRANSPORT_CLIENT_SETTINGS) == 0) {
        return FALSE; /* pictures go to who asks, not where he says */
    }
    if (at->method == GST_RTSP_OPTIONS || is_authorized(self, at)) {
        return TRUE;
    }
    if (strcmp(what, GST_RTSP_AUTH_CHECK_URL) == 0) {
        ask(at);
    }
    return FALSE;
}

static void class_init(gpointer class, gpointer data)
{
    (void)data;
    GST_RTSP_AUTH_CLASS(class)->check = check;
}

static GType auth_type(void)
{
    static gsize type;
    if (g_once_init_enter(&type)) {
        GType made = g_type_register_static_simple(
            GST_TYPE_RTSP_AUTH, "PelRtspAuth", sizeof(GstRTSPAuthClass),
            class_init, sizeof(struct auth), NULL, 0);
        g_once_init_leave(&type, made);
    }
    return type;
}

GstRTSPAuth *pel_rtsp_auth_new(struct pel_token *token)
{
    struct auth *self = g_object_new(auth_type(), NULL);
    self->token = token;
    return &self->parent;
}
