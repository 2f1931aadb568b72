#include "net/rtspauth.h"

#include <string.h>

struct auth {
    GstRTSPAuth parent;
    struct pel_token *token;
    pel_rtsp_admit admit;
    void *user;
};

static struct pel_who who_asks(const struct auth *self,
                               const GstRTSPContext *at)
{
    char *value = NULL, *second = NULL;
    bool one =
        gst_rtsp_message_get_header(at->request, GST_RTSP_HDR_AUTHORIZATION,
                                    &value, 0) == GST_RTSP_OK &&
        gst_rtsp_message_get_header(at->request, GST_RTSP_HDR_AUTHORIZATION,
                                    &second, 1) != GST_RTSP_OK;
    return one ? pel_token_authorizes(self->token, value)
               : (struct pel_who){ PEL_RANK_NOBODY, 0 };
}

static void refuse(GstRTSPContext *at, GstRTSPStatusCode status)
{
    gst_rtsp_message_init_response(
        at->response, status, gst_rtsp_status_as_text(status), at->request);
    if (status == GST_RTSP_STS_UNAUTHORIZED) {
        gst_rtsp_message_add_header(at->response, GST_RTSP_HDR_WWW_AUTHENTICATE,
                                    "Basic realm=\"pelagos\"");
    }
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
    const struct pel_who who = who_asks(self, at);
    bool known = who.rank != PEL_RANK_NOBODY;
    /* Who says who it is has a place, whatever it asks. */
    bool admitted = known && self->admit(self->user, at->client, &who);
    if (admitted || at->method == GST_RTSP_OPTIONS) {
        return TRUE;
    }
    if (strcmp(what, GST_RTSP_AUTH_CHECK_URL) == 0) {
        refuse(at, known ? GST_RTSP_STS_SERVICE_UNAVAILABLE
                         : GST_RTSP_STS_UNAUTHORIZED);
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

GstRTSPAuth *pel_rtsp_auth_new(struct pel_token *token, pel_rtsp_admit admit,
                               void *user)
{
    struct auth *self = g_object_new(auth_type(), NULL);
    self->token = token;
    self->admit = admit;
    self->user = user;
    return &self->parent;
}
