/* An HTTP request as text → routing on a real scene, without sockets: target,
 * query, headers, JSON bodies, edits. Lines up to an empty one are the head,
 * the rest is the body. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "net/http_route.h"

#define MAX_HEADERS 32

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static struct pel_http_context *context(void)
{
    static struct pel_http_context made;
    if (!made.scene) {
        struct pel_scene_options options = { .wave_count = 20 };
        struct pel_fault fault;
        pel_log_set_level(PEL_LOG_ERROR);
        made.metrics = pel_metrics_create();
        made.body_limit = 65536;
        if (pel_scene_create(&options, &made.scene, &fault) != PEL_OK) {
            abort();
        }
    }
    return &made;
}

/* Cuts a line off *text; NULL: none left. */
static char *take_line(char **text)
{
    char *line = *text;
    char *end = strchr(line, '\n');
    if (!end) {
        return NULL;
    }
    *end = '\0';
    *text = end + 1;
    line[strcspn(line, "\r")] = '\0';
    return line;
}

static void serve(char *text, const char *end)
{
    struct pel_http_header headers[MAX_HEADERS];
    struct pel_http_request request = { .headers = headers };
    char *line = take_line(&text);
    char *space = line ? strchr(line, ' ') : NULL;
    if (!space) {
        return;
    }
    *space = '\0';
    request.method = line;
    request.target = space + 1;
    while ((line = take_line(&text)) && *line &&
           request.header_count < MAX_HEADERS) {
        char *colon = strchr(line, ':');
        if (colon) {
            *colon = '\0';
            headers[request.header_count++] =
                (struct pel_http_header){ line,
                                          colon + 1 + strspn(colon + 1, " ") };
        }
    }
    request.body = text;
    request.body_size = (size_t)(end - text);
    struct pel_http_answer answer;
    size_t limit = 0;
    if (pel_http_admit(context(), &request, &limit, &answer)) {
        if (request.body_size > limit) {
            return; /* the server would not have read that much */
        }
        pel_http_route(context(), &request, &answer);
    }
    if (answer.kind == PEL_HTTP_WHOLE &&
        (answer.status < 200 || answer.status > 599)) {
        abort();
    }
    pel_http_answer_finish(&answer);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1);
    memcpy(text, data, size);
    text[size] = '\0';
    serve(text, text + size);
    free(text);
    return 0;
}
