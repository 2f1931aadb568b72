/* HTTP requests as text, one after the other (a byte 1 between them), on a
 * scene of their own, without sockets: target, query, headers, JSON bodies,
 * edits. Lines up to an empty one are the head, the rest is the body. A first
 * line of
 * `#` and letters says what the server has: t a token, h names, o origins that
 * may ask, s it stops, e exercises. */
#include <string.h>
#include <unistd.h>

#include "fuzz_steps.h"
#include "net/http_route.h"
#include "net/series_parts.h"
#include "scene/exercise.h"

#define MAX_HEADERS 32

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static struct pel_http_context context;

static struct pel_token *token(void)
{
    static struct pel_token *made;
    char path[] = "/tmp/pelagos-fuzz-XXXXXX";
    static const char text[] = "0123456789abcdef\n";
    if (!made) {
        int fd = mkstemp(path);
        if (fd < 0 ||
            write(fd, text, sizeof text - 1) != (ssize_t)sizeof text - 1 ||
            pel_token_create(path, &made, NULL)) {
            abort();
        }
        close(fd);
        unlink(path);
    }
    return made;
}

/* A folder in memory, which those of one input leave empty. */
static const char *exercises(void)
{
    static char path[] = "/dev/shm/pelagos-fuzz-XXXXXX";
    static bool made;
    if (!made) {
        fuzz_demand(mkdtemp(path) != NULL);
        made = true;
    }
    GDir *folder = g_dir_open(path, 0, NULL);
    for (const char *name; (name = g_dir_read_name(folder));) {
        char *file = g_build_filename(path, name, NULL);
        unlink(file);
        g_free(file);
    }
    g_dir_close(folder);
    return path;
}

static void set_context(const char *letters, struct pel_scene *scene)
{
    static struct pel_metrics *metrics;
    static const char *const hosts[] = { "sea.example", NULL };
    static const char *const origins[] = { "https://other.example", NULL };
    if (!metrics) {
        metrics = pel_metrics_create();
    }
    context = (struct pel_http_context){
        .scene = scene,
        .metrics = metrics,
        .body_limit = 65536,
        .token = strchr(letters, 't') ? token() : NULL,
        .hosts = strchr(letters, 'h') ? hosts : NULL,
        .origins = strchr(letters, 'o') ? origins : NULL,
        .stopping = strchr(letters, 's') != NULL,
    };
    if (strchr(letters, 'e')) {
        const struct pel_exercises_options options = { exercises(), NULL };
        fuzz_demand(
            !pel_exercises_create(&options, scene, &context.exercises, NULL));
    }
}

/* A patch is one revision more, or nothing. */
static void carry_out(struct pel_http_answer *answer)
{
    uint64_t before = pel_scene_state(context.scene)->revision;
    struct pel_fault fault = { 0 };
    enum pel_err err = pel_scene_patch(context.scene, answer->patch, &fault);
    uint64_t after = pel_scene_state(context.scene)->revision;
    fuzz_demand(after == before + (err == PEL_OK));
    fuzz_demand(err == PEL_OK || fault.message[0]);
    struct pel_http_answer told = { 0 };
    if (err) {
        pel_http_answer_refused(&told, &fault);
    } else {
        pel_http_answer_state(&context, PEL_ROLE_INSTRUCT, &told);
    }
    fuzz_demand(told.status >= 200 && told.status < 500 && told.size > 0);
    pel_http_answer_finish(&told);
}

/* Its first cells are questions. */
static void plan_series(const struct pel_http_answer *answer)
{
    struct pel_series_plan plan;
    struct pel_fault fault = { 0 };
    ProtobufCMessage *question;
    if (pel_series_plan_make(answer->series, &plan, &fault)) {
        fuzz_demand(fault.message[0]);
    } else {
        pel_series_plan_at(&plan, 3);
        for (size_t n = 0; n < plan.cells && n < 9; n++) {
            size_t cell = pel_series_cell(&plan, n);
            fuzz_demand(cell < plan.cells);
            if (pel_series_question(&plan, cell, &question, &fault)) {
                fuzz_demand(fault.message[0]);
            } else {
                protobuf_c_message_free_unpacked(question, NULL);
            }
        }
    }
    pel_series_plan_finish(&plan);
}

static void command_exercise(struct pel_http_answer *answer)
{
    Pelagos__ExerciseStatus *status;
    struct pel_fault fault;
    if (pel_exercises_command(context.exercises, answer->exercise, &status,
                              &fault) == PEL_OK) {
        pelagos__exercise_status__free_unpacked(status, NULL);
    }
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
    space[1 + strcspn(space + 1, " ")] = '\0'; /* HTTP/1.1 */
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
    if (pel_http_admit(&context, &request, &limit, &answer)) {
        if (request.body_size > limit) {
            return; /* the server would not have read that much */
        }
        pel_http_answer_finish(&answer);
        pel_http_route(&context, &request, &answer);
        pel_http_write(&answer);
    }
    fuzz_demand(answer.kind != PEL_HTTP_WHOLE ||
                (answer.status >= 200 && answer.status <= 599));
    if (answer.kind == PEL_HTTP_PATCH) {
        carry_out(&answer);
    } else if (answer.kind == PEL_HTTP_SERIES) {
        plan_series(&answer);
    } else if (answer.kind == PEL_HTTP_EXERCISE) {
        command_exercise(&answer);
    }
    pel_http_answer_finish(&answer);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1), *rest = text, *end = text + size;
    struct pel_scene *scene = fuzz_world();
    memcpy(text, data, size);
    text[size] = '\0';
    char *letters = text[0] == '#' ? take_line(&rest) : NULL;
    set_context(letters ? letters : "", scene);
    for (int i = 0; i < 16 && rest < end; i++) {
        char *stop = memchr(rest, 1, (size_t)(end - rest));
        stop = stop ? stop : end;
        *stop = '\0';
        serve(rest, stop);
        rest = stop + 1;
    }
    pel_exercises_destroy(context.exercises);
    pel_scene_destroy(scene);
    free(text);
    return 0;
}
